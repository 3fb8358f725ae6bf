// Pictures of 1920 x 1080 pixels, as `psim --image` and films draw them:
//   Draw/<scene>/<bodies>   a world's bodies painted and turned into 8-bit sRGB
//   Png/<scene>/<bodies>    that picture compressed
//   File/<scene>/<bodies>   both; CPU is the time of all threads together
//   Draw/water/<particles>  the surface of a pool in a wide tank; Draw/particles/<particles>: its particles as discs
// The last number is that of threads.
// Worlds stand as they begin: a pile fills the height of the picture with discs 2 % of their size apart.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "picture/painter.h"
#include "picture/png_write.h"
#include "workload.h"

namespace psim::bench {
namespace {

constexpr int kWidth = 1920, kHeight = 1080;

// A pool 5 m wide and as deep as it takes, in a tank of 8 m; particles are 1 cm apart.
Scene pool(std::uint64_t particles) {
  Scene scene;
  scene.world.bounds = {0, 0, 8, 4.5};
  scene.fluids.resize(1);
  scene.fluids[0].fluid.spacing = 0.01;
  scene.fluids[0].place = Bounds{0, 0, 5, 0.01 * static_cast<double>(particles) / 500};
  return scene;
}

struct Picture {
  Picture(const char* name, std::uint64_t bodies) {
    std::string error;
    if (name == std::string_view("water") || name == std::string_view("particles")) {
      scene = pool(bodies);
    } else if (auto made = make_builtin(name, bodies, 1, error)) {
      scene = std::move(*made);
    }
    const auto world = build_world(scene, {}, error);
    cli::take_moment(*world, moment, cli::Colouring::speed);
  }
  // Bodies of every colour, as in the midst of a run.
  void stir() {
    for (std::size_t row = 0; row < moment.size(); ++row) {
      moment.vx[row] = static_cast<double>(row % 1000);
    }
  }
  Scene scene;
  cli::Moment moment;
};

void draw(benchmark::State& state, const char* scene, std::uint64_t bodies, char what, int threads) {
  Picture picture(scene, bodies);
  picture.stir();
  cli::PictureOptions options;
  if (scene == std::string_view("particles")) options.fluid_style = cli::FluidStyle::particles;
  const cli::Painter painter(picture.scene, options);
  const Bounds view = cli::view_of_all(picture.scene, picture.moment, painter.shapes());
  cli::Canvas canvas(kWidth, kHeight);
  std::vector<std::uint8_t> rgb;
  const auto paint = [&] {
    const cli::Brightest bright = cli::brightest(picture.scene, picture.moment, painter.shapes());
    painter.paint(canvas, cli::PictureCamera(view, kWidth, kHeight), picture.moment, bright);
    canvas.to_srgb(rgb, threads);
  };
  paint();
  cli::AtomicFile nowhere("bench", "/dev/null");
  for (auto _ : state) {
    if (what != 'P') paint();
    if (what != 'D') cli::write_png(nowhere, kWidth, kHeight, rgb, threads);
    benchmark::DoNotOptimize(rgb.data());
  }
  state.counters["bodies"] = static_cast<double>(picture.moment.size());
}

}  // namespace

void register_pictures() {
  struct Line {
    const char* what;
    const char* scene;
    std::uint64_t bodies;
    int threads = 1;
  };
  for (const Line& line : {Line{"Draw", "discs", 100'000},
                           {"Draw", "pile", 10'000},
                           {"Draw", "pile", 100'000},
                           {"Draw", "pile", 1'000'000},
                           {"Draw", "many_pyramids", 22'000},
                           {"Draw", "rain", 11'000},
                           {"Draw", "water", 100'000},
                           {"Draw", "particles", 100'000},
                           {"Png", "pile", 100'000},
                           {"Png", "many_pyramids", 22'000},
                           {"File", "pile", 100'000},
                           {"File", "pile", 100'000, 2}}) {
    const std::string name = std::string(line.what) + "/" + line.scene + "/" + std::to_string(line.bodies) + "/" +
                             std::to_string(line.threads);
    benchmark::RegisterBenchmark(
        name.c_str(), [line](benchmark::State& s) { draw(s, line.scene, line.bodies, line.what[0], line.threads); })
        ->Unit(benchmark::kMillisecond)
        ->MeasureProcessCPUTime();
  }
}

}  // namespace psim::bench
