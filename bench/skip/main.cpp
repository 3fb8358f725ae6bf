// Does a frame cost what happens in it, or what exists? Each row measures a world against one that lacks what should
// cost nothing, in turn, and prints the ratio beside the most that docs/performance.md promises. CPU time of one
// thread; of each frame the least of the runs counts, other programs only add.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "psim/psim.h"
#include "psim/scene.h"

namespace {

using namespace psim;

// Of the calling thread.
double worked_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

double mean(const std::vector<double>& of) {
  return std::accumulate(of.begin(), of.end(), 0.0) / static_cast<double>(of.size());
}

std::unique_ptr<World> world_of(const WorldDesc& desc) {
  std::string error;
  auto world = World::create(desc, {best_isa(), 1}, error);
  if (!world) throw std::runtime_error(error);
  return world;
}

class Random {  // a linear congruential generator (Knuth)
 public:
  double within(double most) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return most * (static_cast<double>(state_ >> 11) * 0x1p-52 - 1);
  }

 private:
  std::uint64_t state_ = 1;
};

struct Discs {
  std::vector<double> x, y, vx, vy;

  void add(World& world, BodyType type = BodyType::dynamic_body, double friction = 0) const {
    const double radius = 0.5;
    DiscBatch batch;
    batch.x = x;
    batch.y = y;
    batch.vx = vx;
    batch.vy = vy;
    batch.radius = {&radius, 1};
    batch.type = type;
    batch.material.friction = friction;
    std::uint32_t first = 0;
    std::string error;
    if (world.add_discs(batch, first, error) != x.size()) throw std::runtime_error(error);
  }
};

// A square of discs about (x, y), half of its area free, up to 3 m/s an axis.
Discs gas(std::size_t count, double x, double y) {
  Discs discs;
  Random random;
  const auto columns = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  const double pitch = 1.414, half = pitch * static_cast<double>(columns) / 2;
  for (std::size_t k = 0; k < count; ++k) {
    discs.x.push_back(x - half + pitch * static_cast<double>(k % columns) + random.within(0.1));
    discs.y.push_back(y - half + pitch * static_cast<double>(k / columns) + random.within(0.1));
    discs.vx.push_back(random.within(3));
    discs.vy.push_back(random.within(3));
  }
  return discs;
}

WorldDesc space() {
  WorldDesc desc;
  desc.bounds = {-2e5, -2e5, 2e5, 2e5};
  desc.boundary = Boundary::open;
  desc.gravity = {0, 0};
  return desc;
}

// ms of each of so many frames.
std::vector<double> frames_of(World& world, int frames, const std::function<void(int)>& before = {}) {
  std::vector<double> took;
  for (int k = 0; k < frames; ++k) {
    if (before) before(k);
    const double begin = worked_ms();
    world.step();
    took.push_back(worked_ms() - begin);
  }
  return took;
}

using BodyKind = std::function<std::unique_ptr<World>()>;

// Mean ms of a frame of one world and another, after 20.
std::pair<double, double> in_turn(const BodyKind& one, const BodyKind& other, int frames, int runs) {
  const auto a_run = [&](const BodyKind& make, std::vector<double>& least) {
    const auto world = make();
    world->prepare();
    frames_of(*world, 20);
    const std::vector<double> took = frames_of(*world, frames);
    if (least.empty()) least = took;
    for (std::size_t k = 0; k < took.size(); ++k) least[k] = std::min(least[k], took[k]);
  };
  std::vector<double> a, b;
  for (int k = 0; k < runs; ++k) {
    a_run(one, a);
    a_run(other, b);
  }
  return {mean(a), mean(b)};
}

void row(const std::string& what, double ms, const std::string& against, double than, double most) {
  const double ratio = ms / than;
  const auto as = [most](double value) {
    return most < 0.5 ? fmt::format("{:.3f} %", 100 * value) : fmt::format("{:.2f}", value);
  };
  fmt::print("| {} | {:.4f} | {} | {:.4f} | {} | {} |{}\n", what, ms, against, than, as(ratio), as(most),
             ratio <= most ? "" : " over");
  std::fflush(stdout);
}

void fixed_discs(int runs) {
  const Discs moving = gas(1000, 0, 0);
  Discs wide, near;  // pegs 4 m apart, and those of them that the moving ones may meet
  for (int i = -500; i < 500; ++i) {
    for (int j = -500; j < 500; ++j) {
      const double x = 4 * i + 2, y = 4 * j + 2;
      if (std::fabs(x) < 26 && std::fabs(y) < 26) continue;  // where they begin
      wide.x.push_back(x);
      wide.y.push_back(y);
      if (std::fabs(x) < 60 && std::fabs(y) < 60) {
        near.x.push_back(x);
        near.y.push_back(y);
      }
    }
  }
  const auto with = [&](const Discs& pegs) {
    return [&] {
      auto world = world_of(space());
      pegs.add(*world, BodyType::static_body);
      moving.add(*world);
      return world;
    };
  };
  const auto [all, few] = in_turn(with(wide), with(near), 300, runs);
  row(fmt::format("1,000 discs among {} static ones", wide.x.size()), all,
      fmt::format("the {} of these nearby", near.x.size()), few, 1.3);
  const auto [early, alone] = in_turn(with(wide), with({}), 60, runs);
  row("the same, before they meet any", early, "alone", alone, 1.3);
}

void clusters(int runs) {
  const auto apart = [](double x, double y) {
    return [x, y] {
      auto world = world_of(space());
      gas(5000, -x / 2, -y / 2).add(*world);
      gas(5000, x / 2, y / 2).add(*world);
      return world;
    };
  };
  const auto [far, close] = in_turn(apart(1e5, 0), apart(150, 0), 180, runs);
  row("two clusters of 5,000, 100 km apart", far, "150 m apart", close, 1.1);
  const auto [both, again] = in_turn(apart(1e5, 1e5), apart(150, 0), 180, runs);
  row("100 km apart in x and in y", both, "150 m apart", again, 1.1);
}

// A frame a contact, of 90 frames from where each has landed and both have about as many: 210,000 to 240,000.
void sizes() {
  const auto per_contact = [](const char* scene, int landed) {
    std::string error;
    const auto made = make_builtin(scene, 100000, 1, error);
    if (!made) throw std::runtime_error(error);
    const auto world = build_world(*made, {best_isa(), 1}, error);
    if (!world) throw std::runtime_error(error);
    world->set_sleeping(false);
    double ms = 0, contacts = 0;
    for (int k = 0; k < landed + 90; ++k) {
      const double begin = worked_ms();
      const StepReport report = world->step();
      if (k < landed) continue;
      ms += worked_ms() - begin;
      contacts += static_cast<double>(report.contacts);
    }
    return 1e5 * ms / contacts;
  };
  const double mixed = per_contact("mixed-sizes", 330), equal = per_contact("rough-pile", 240);
  row("100,000 radii 1 : 50, for 100,000 contacts", mixed, "equal radii", equal, 2);
}

void few_discs() {
  WorldDesc desc;
  desc.bounds = {0, 0, 20, 20};
  desc.sleeping = false;
  const auto world = world_of(desc);
  gas(10, 10, 10).add(*world);
  frames_of(*world, 600);
  const auto took = frames_of(*world, 20000);
  row("10 discs in a box, awake", mean(took), "5 µs", 0.005, 1);
}

void pile() {
  WorldDesc desc;
  constexpr std::size_t kColumns = 330, kDiscs = 100000;
  desc.bounds = {0, 0, kColumns + 0.5, 700};
  desc.wall.friction = 0.5;
  const auto world = world_of(desc);
  Discs discs;  // as they lie densest
  for (std::size_t k = 0; k < kDiscs; ++k) {
    const std::size_t row_of = k / kColumns;
    discs.x.push_back(0.5 + static_cast<double>(k % kColumns) + (row_of % 2 == 1 ? 0.5 : 0));
    discs.y.push_back(0.5 + static_cast<double>(row_of) * std::sqrt(0.75));
  }
  discs.add(*world, BodyType::dynamic_body, 0.5);
  std::uint64_t asleep = 0;
  for (int k = 0; k < 12000 && asleep != kDiscs; ++k) asleep = world->step().asleep;
  if (asleep != kDiscs) throw std::runtime_error(fmt::format("only {} of the pile's discs fell asleep", asleep));
  std::vector<std::byte> state;
  std::string error;
  world->save(state);
  const double still = mean(frames_of(*world, 300));
  int dropped = 0;
  const double hit = mean(frames_of(*world, 1200, [&](int frame) {
    if (frame % 60 != 0) return;
    BodyDesc disc;
    disc.shape = DiscShape{0.5};
    disc.position = {20.0 + dropped++ * 37 % 290, 290};
    disc.material.friction = 0.5;
    world->add_body(disc, error);
  }));
  if (!world->restore(state, error)) throw std::runtime_error(error);
  world->set_sleeping(false);
  frames_of(*world, 60);
  std::vector<double> took;
  int passed = 0;
  for (int k = 0; k < 300; ++k) {
    const double begin = worked_ms();
    const StepReport report = world->step();
    took.push_back(worked_ms() - begin);
    for (std::size_t bit = 0; bit < kSkipNames.size(); ++bit) {
      passed += kSkipNames[bit] == "broad_phase" && (report.skipped >> bit & 1u) != 0;
    }
  }
  const double awake = mean(took);
  row("pile of 100,000, asleep", still, "awake", awake, 0.01);
  row("asleep, a disc dropped on it every second", hit, "awake", awake, 0.1);
  fmt::print(
      "| frames without a broad phase, at rest and awake | {} | of | 300 | {:.0f} % | 90 % at "
      "least |{}\n",
      passed, static_cast<double>(passed) / 3, passed >= 270 ? "" : " under");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"What a frame costs for what exists and does not happen"};
  int runs = 3;
  app.add_option("--runs", runs, "of which the least time counts")->check(CLI::Range(1, 100));
  CLI11_PARSE(app, argc, argv);
  fmt::print(
      "| what | ms a frame | against | ms a frame | ratio | at most "
      "|\n|---|---|---|---|---|---|\n");
  try {
    few_discs();
    clusters(runs);
    fixed_discs(runs);
    pile();
    sizes();
  } catch (const std::exception& e) {
    fmt::print(stderr, "skip: {}\n", e.what());
    return 1;
  }
}
