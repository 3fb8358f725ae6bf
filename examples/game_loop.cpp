// A game loop: the physics takes fixed steps, the picture is drawn between two of them. However
// unevenly frames come, the physics takes the same steps, and motion on the screen is smooth.
#include <psim/psim.h>

#include <cmath>
#include <cstdio>
#include <string>

namespace {

// Stands for the renderer: how far did the ball go on the screen since the last picture?
struct Picture {
  double x = 0;
  double worst_jerk = 0;  // m/s: error of the speed seen, which is 3 m/s
  int drawn = 0;

  void draw(const psim::Snapshot& s, double alpha, double frame_s) {
    const double x_prev = static_cast<double>(s.x_prev[0]), x_now = static_cast<double>(s.x[0]);
    const double seen = x_prev + alpha * (x_now - x_prev);
    if (drawn > 2) worst_jerk = std::fmax(worst_jerk, std::fabs((seen - x) / frame_s - 3));
    x = seen;
    ++drawn;
  }
};

}  // namespace

int main() {
  psim::WorldDesc desc;
  desc.gravity = {0, 0};
  desc.dt = 1.0 / 60;
  std::string error;
  const auto world = psim::World::create(desc, {}, error);
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 1;
  psim::BodyDesc ball;
  ball.velocity = {3, 0};
  world->add_body(ball, error);
  world->enable_snapshots(true);  // keeps this frame and the one before for the renderer

  Picture picture;
  double due_s = 0;
  for (int frame = 0; frame < 144; ++frame) {
    // A real loop measures this: a screen of 144 Hz that stumbles now and then.
    double frame_s = 1.0 / 144 + (frame % 50 == 49 ? 0.03 : 0);
    frame_s = std::fmin(frame_s, 0.25);  // after a long pause the game waits, it does not race
    for (due_s += frame_s; due_s >= desc.dt; due_s -= desc.dt) world->step();
    if (const psim::Snapshot* s = world->latest_snapshot()) {
      picture.draw(*s, due_s / desc.dt, frame_s);
    }
  }
  std::printf("%llu steps, %d pictures, speed on the screen 3 m/s +- %.4f\n",
              static_cast<unsigned long long>(world->frame()), picture.drawn, picture.worst_jerk);
}
