// 100,000 discs in one call: columns of numbers in, columns of numbers out.
#include <psim/psim.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

int main() {
  using Clock = std::chrono::steady_clock;
  const auto ms_since = [](Clock::time_point t) {
    return std::chrono::duration<double, std::milli>(Clock::now() - t).count();
  };
  constexpr std::size_t kCount = 100'000;
  std::vector<double> x(kCount), y(kCount), vx(kCount);
  for (std::size_t k = 0; k < kCount; ++k) {
    x[k] = static_cast<double>(k % 400) * 1.2 - 240;
    y[k] = static_cast<double>(k / 400) * 1.2 - 499;
    vx[k] = k % 2 == 0 ? 3 : -3;
  }
  const double radius = 0.5;  // of all of them; or one number a disc

  psim::RunOptions options;
  options.threads = 2;
  std::string error;
  const auto world = psim::World::create({}, options, error);
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  psim::DiscBatch batch;
  batch.x = x;
  batch.y = y;
  batch.vx = vx;
  batch.radius = {&radius, 1};
  std::uint32_t first = 0;  // ids are first, first + 1, ...
  auto begin = Clock::now();
  if (world->add_discs(batch, first, error) != kCount) {
    return std::fprintf(stderr, "%s\n", error.c_str()), 1;
  }
  const double spawn_ms = ms_since(begin);
  world->prepare();  // what else the first step would pay for
  begin = Clock::now();
  for (int frame = 0; frame < 10; ++frame) world->step();
  std::printf("spawned in %.1f ms, then %.2f ms a step\n", spawn_ms, ms_since(begin) / 10);

  // Columns by id; the spans are valid until the world changes.
  const psim::PublishedState state = world->published();
  std::printf("%zu discs, the highest at y = %.2f m\n", state.id.size(),
              *std::max_element(state.y.begin(), state.y.end()));
}
