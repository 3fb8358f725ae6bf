// Step lengths, mass ratios, overlaps and crowds: what the contact solver is asked to carry.
#include <array>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "stress_trial.h"

namespace psim::accuracy::stress {

std::unique_ptr<Simulation> start_psim(const Model& model) {
  Setting setting;
  setting.frame = model.scene.world.dt;
  setting.substeps = model.scene.world.substeps;
  return psim_engine().make(model, setting);
}

// ---- length of the step -----------------------------------------------------------------------

namespace {

Scene bin(double dt, Material m, int shift = 0) {
  constexpr int kColumns = 15;
  const double width = kColumns * 1.02 + 1;
  Scene scene = walled_scene(width, 4 * width, m, {0, -kGravity});
  scene.world.dt = dt;
  for (int j = 0; j < kColumns; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      scene.bodies.push_back(disc(
          {1 + 1.02 * i + 0.007 * ((i * 7 + j * 13) % 3) + 0.0001 * shift * ((i * 5 + j * 3) % 7), 0.51 + 1.02 * j}, {},
          m));
    }
  }
  return scene;
}

bool all_inside(Run& run) {
  const Bounds& b = run.model().scene.world.bounds;
  return std::ranges::all_of(run.bodies(), [&b](const BodyState& s) {
    return s.x >= b.xmin && s.x <= b.xmax && s.y >= b.ymin && s.y <= b.ymax;
  });
}

Landing watch_landing(const Scene& scene, const Start& start, int frames) {
  Trial trial(scene, start);
  Landing landing;
  try {
    const double before = energy(trial.run());
    for (int k = 0; k < frames; ++k) {
      trial.frame();
      landing.energy_gain = std::max(landing.energy_gain, energy(trial.run()) / before - 1);
    }
    landing.whole = all_inside(trial.run());
    landing.speed = rms_speed(trial.run());
    landing.overlap = deepest(trial.run()) / kDiameter;
  } catch (const Failed&) {
    landing.whole = false;
  }
  return landing;
}

constexpr double kLandingTime = 20;  // s

/// psim with frames of any length: `length_of(k)` is that of frame k, s.
class UnevenFrames : public Simulation {
 public:
  using LengthOf = std::function<double(int)>;

  UnevenFrames(const Model& model, LengthOf length_of) : length_of_(std::move(length_of)) {
    std::string error;
    world_ = build_world(model.scene, {best_isa(), 1}, error);
    if (!world_) throw std::runtime_error(error);
    world_->set_sleeping(false);
  }
  void advance() override { world_->step(length_of_(frame_++)); }
  void read(std::vector<BodyState>& bodies) override {
    bodies.clear();
    for (const std::uint32_t id : world_->published().id) {
      bodies.push_back(*world_->body(world_->id_of(id)));
    }
  }
  void set_velocity(std::size_t body, Vec2 velocity, double omega) override {
    world_->set_velocity(world_->id_of(static_cast<std::uint32_t>(body)), velocity, omega);
  }
  double row_visits() const override { return 0; }

 private:
  std::unique_ptr<World> world_;
  LengthOf length_of_;
  int frame_ = 0;
};

Start uneven(const UnevenFrames::LengthOf& length_of) {
  return [length_of](const Model& model) { return std::make_unique<UnevenFrames>(model, length_of); };
}

constexpr Material kRough{1, 0.3, 0.5};

}  // namespace

bool Landing::stable() const { return whole && energy_gain < 0.01 && speed < 0.05 && overlap < 0.1; }

Landing land(double dt, double restitution, double friction, const Start& start) {
  const int frames = std::max(20, static_cast<int>(std::ceil(kLandingTime / dt)));
  return watch_landing(bin(dt, {1, restitution, friction}), start, frames);
}

Landing usual_landing(double dt, double restitution, double friction) {
  constexpr int kStarts = 7;
  std::vector<double> speed, overlap;
  Landing usual;
  usual.whole = true;
  for (int k = 0; k < kStarts; ++k) {
    const int frames = std::max(20, static_cast<int>(std::ceil(2 * kLandingTime / dt)));
    const Landing one = watch_landing(bin(dt, {1, restitution, friction}, k), start_psim, frames);
    usual.whole = usual.whole && one.whole;
    usual.energy_gain = std::max(usual.energy_gain, one.energy_gain);
    speed.push_back(one.speed);
    overlap.push_back(one.overlap);
  }
  for (const auto& [column, value] : {std::pair(&speed, &usual.speed), std::pair(&overlap, &usual.overlap)}) {
    std::ranges::nth_element(*column, column->begin() + kStarts / 2);
    *value = (*column)[kStarts / 2];
  }
  return usual;
}

double largest_stable_step(const Start& start) {
  constexpr std::array<double, 12> kPerSecond = {240, 120, 60, 45, 30, 25, 20, 15, 10, 5, 2, 1};
  double largest = 0;
  for (const double per_second : kPerSecond) {
    const double dt = 1 / per_second;
    if (!land(dt, 0, 0, start).stable()) break;
    if (!land(dt, kRough.restitution, kRough.friction, start).stable()) break;
    largest = dt;
  }
  return largest;
}

Landing land_at_random_steps(double shortest, double longest) {
  const auto length_of = [=, bits = std::uint64_t{1}](int) mutable {
    bits = bits * 6364136223846793005u + 1442695040888963407u;
    return shortest + (longest - shortest) * static_cast<double>(bits >> 11) * 0x1p-53;
  };
  const int frames = static_cast<int>(std::ceil(2 * kLandingTime / (shortest + longest)));
  return watch_landing(bin(1.0 / 60, kRough), uneven(length_of), frames);
}

double speed_after_another_step(double dt) {
  constexpr int kFramesToRest = 1200;
  Trial trial(bin(1.0 / 60, kRough), uneven([dt](int frame) { return frame == kFramesToRest ? dt : 1.0 / 60; }));
  trial.frames(kFramesToRest + 1);
  return trial.fastest_within(60);
}

// ---- mass ratios ------------------------------------------------------------------------------

Load heavy_on_light(double ratio, const Start& start) {
  Scene scene = open_scene(1024);
  BodyDesc light = disc({0, kRadius}, {}, material(0));
  light.mass = 1;
  light.fixed_rotation = true;
  BodyDesc heavy = light;
  heavy.position.y = 3 * kRadius;
  heavy.mass = ratio;
  scene.bodies = {ground(material(0), 1000), light, heavy};
  Trial trial(scene, start);
  trial.frames(600);
  const BodyState &l = trial.body(1), &u = trial.body(2);
  const double below = kRadius - l.y, above = kDiameter - std::hypot(u.x - l.x, u.y - l.y);
  return {std::max(below, above) / kRadius, trial.fastest()};
}

double first_sinking_ratio(double overlap, const Start& start) {
  double ratio = 1;
  while (ratio < 1e7 && heavy_on_light(ratio, start).overlap <= overlap) ratio *= 1.1;
  return ratio;
}

double elastic_pair_error(double ratio, const Start& start) {
  constexpr double kSpeed = 7;
  double worst = 0;
  for (int k = 0; k < 20; ++k) {
    const double offset = 0.049 * k, along = std::sqrt(1 - offset * offset);
    BodyDesc comer = disc({-3.03 - along, offset}, {kSpeed, 0}, material(1));
    BodyDesc target = disc({0, 0}, {0, 0}, material(1));
    comer.mass = 1;
    target.mass = ratio;
    Scene scene = open_scene(1024, {0, 0});
    scene.bodies = {comer, target};
    Trial trial(scene, start);
    trial.frames(60);
    const Vec2 n = {along, -offset};  // from the comer to the target, at the impact
    const double impulse = 2 * kSpeed * along * ratio / (1 + ratio);
    const BodyState &p = trial.body(0), &q = trial.body(1);
    worst = std::max({worst, std::hypot(p.vx - kSpeed + impulse * n.x, p.vy + impulse * n.y),
                      std::hypot(q.vx - impulse / ratio * n.x, q.vy - impulse / ratio * n.y)});
  }
  return worst / kSpeed;
}

double gravel_speed(const Start& start) {
  constexpr std::size_t kStones = 60;
  Scene scene = open_scene(1024);
  scene.bodies.push_back(ground(material(0), 1000));
  for (std::size_t k = 0; k < kStones; ++k) {
    scene.bodies.push_back(disc({-3 + 0.1 * static_cast<double>(k), 0.05}, {}, material(0), 0.05));
  }
  scene.bodies.push_back(disc({0, 20.6}, {}, material(0), 20));
  Trial trial(scene, start);
  double speed = 0;
  for (int k = 0; k < 300; ++k) {
    trial.frame();
    for (std::size_t stone = 1; stone <= kStones; ++stone) {
      speed = std::max(speed, std::hypot(trial.body(stone).vx, trial.body(stone).vy));
    }
  }
  return speed;
}

// ---- overlaps ---------------------------------------------------------------------------------

OnePoint one_point(int discs, const Start& start) {
  Scene scene = open_scene(1024, {0, 0});
  for (int k = 0; k < discs; ++k) scene.bodies.push_back(disc({3.25, -1.5}, {}, material(0)));
  Trial trial(scene, start);
  trial.frames(120);
  double x = 0, y = 0, sum = 0;
  for (const BodyState& b : trial.bodies()) {
    x += b.vx;
    y += b.vy;
    sum += std::hypot(b.vx, b.vy);
  }
  return {trial.fastest(), sum > 0 ? std::hypot(x, y) / sum : 0, deepest(trial.run()) / kDiameter};
}

double speed_from_overlap(double overlap, double restitution, double mass_ratio, const Start& start) {
  Scene scene = open_scene(1024, {0, 0});
  BodyDesc a = disc({0, 0}, {}, material(restitution)), b = a;
  b.position.x = kDiameter * (1 - overlap);
  a.mass = 1;
  b.mass = mass_ratio;
  scene.bodies = {a, b};
  return Trial(scene, start).fastest_within(300);
}

double speed_from_overlapping_block(double overlap, double restitution, const Start& start) {
  constexpr int kSide = 12;
  const double pitch = kDiameter * (1 - overlap);
  Scene scene = open_scene(1024, {0, 0});
  for (int k = 0; k < kSide * kSide; ++k) {
    scene.bodies.push_back(disc({(k % kSide) * pitch, (k / kSide) * pitch}, {}, material(restitution)));
  }
  return Trial(scene, start).fastest_within(300);
}

double jump_from_the_ground(double overlap, const Start& start) {
  Scene scene = open_scene(1024);
  scene.bodies = {ground(material(0), 1000), disc({0, kRadius * (1 - overlap)}, {}, material(0))};
  Trial trial(scene, start);
  double height = 0;
  for (int k = 0; k < 300; ++k) {
    trial.frame();
    height = std::max(height, trial.body(1).y - kRadius);
  }
  return height;
}

// ---- crowds -----------------------------------------------------------------------------------

Crowd ring_on_a_big_disc(const Start& start) {
  constexpr double kBig = 20, kSmall = 0.1;
  Scene scene = open_scene(64, {0, 0});
  // A pull of g everywhere but at the centre.
  scene.world.fields.push_back(WellField{{0, 0}, kGravity, 1, 0, 0});
  scene.bodies.push_back(disc({0, 0}, {}, material(0), kBig));
  for (int k = 0; k < 600; ++k) {
    const double angle = 2 * std::numbers::pi * k / 600;
    scene.bodies.push_back(
        disc({(kBig + 0.2) * std::cos(angle), (kBig + 0.2) * std::sin(angle)}, {}, material(0), kSmall));
  }
  Trial trial(scene, start);
  trial.frames(600);
  return {deepest(trial.run()), trial.fastest()};
}

Crowd discs_on_a_plate(const Start& start) {
  Scene scene = open_scene(1024);
  scene.bodies = {segment({-0.01, 0}, {200.5, 0}, material(0)), segment({-0.01, 0}, {-0.01, 60}, material(0)),
                  segment({200.5, 0}, {200.5, 60}, material(0))};
  for (int j = 0; j < 50; ++j) {
    for (int i = 0; i < 200; ++i) {
      scene.bodies.push_back(
          disc({0.5 + 1.002 * i + 0.001 * ((i * 7 + j * 13) % 2), 0.5 + 1.001 * j}, {}, material(0)));
    }
  }
  Trial trial(scene, start);
  trial.frames(1200);
  return {deepest(trial.run()), trial.fastest()};
}

}  // namespace psim::accuracy::stress
