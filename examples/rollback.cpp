// Rollback: the other player's inputs come late and out of order. The game guesses them; when a guess was wrong, it goes
// back to a saved state and steps again. Exits with 1 if it ends with other bits than a game with all inputs on time.
#include <psim/psim.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

constexpr int kFrames = 600, kLatest = 12;  // an input comes at most so many frames late

// Stand for the players and the network: which way a player steers, as if by chance, and when the other one hears of it.
int input(int player, int frame) {
  const unsigned chance = (static_cast<unsigned>(frame / 15 * 2 + player) * 2654435761u) >> 16;
  return static_cast<int>(chance % 3) - 1;
}
int arrival(int frame) { return frame + kLatest - frame * 7 % 9; }

std::unique_ptr<psim::World> make_game(const psim::RunOptions& options, std::string& error) {
  auto world = psim::World::create({.bounds = {-20, 0, 20, 40}, .wall = {.friction = 0.6}}, options, error);
  if (!world) return world;
  for (const double x : {-9.0, 9.0}) world->add_body({.position = {x, 0.5}, .mass = 5}, error);  // the players
  psim::BodyDesc crate{.shape = psim::BoxShape{0.5, 0.5}, .material = {.friction = 0.6}};
  for (int k = 0; k < 200; ++k) {
    crate.position = {0.6 * (k % 20) - 6, 0.25 + 0.5 * (k / 20)};
    world->add_body(crate, error);
  }
  return world;
}

void step(psim::World& world, int first, int second) {
  world.apply_force(world.id_of(0), {60.0 * first, 0});  // N
  world.apply_force(world.id_of(1), {60.0 * second, 0});
  world.step();
}

}  // namespace

int main() {
  using Clock = std::chrono::steady_clock;
  std::string error;
  const auto on_time = make_game({.threads = 2}, error), late = make_game({.isa = psim::Isa::scalar}, error);
  if (!on_time || !late) return std::fprintf(stderr, "%s\n", error.c_str()), 1;
  for (int frame = 0; frame < kFrames; ++frame) step(*on_time, input(0, frame), input(1, frame));

  std::vector<std::byte> saved[kFrames];  // before each frame; a game needs no more than the last kLatest
  std::optional<int> known[kFrames];
  int used[kFrames] = {}, rollbacks = 0, again = 0;
  std::chrono::duration<double, std::milli> cost{};
  for (int now = 0; now <= kFrames + kLatest; ++now) {
    int from = now;  // the first frame to step
    for (int frame = std::max(0, now - kLatest); frame < std::min(now, kFrames); ++frame) {
      if (arrival(frame) != now) continue;
      known[frame] = input(1, frame);
      if (used[frame] != *known[frame]) from = std::min(from, frame);
    }
    const auto begin = Clock::now();
    if (from < now && !late->restore(saved[from], error)) return std::fprintf(stderr, "%s\n", error.c_str()), 1;
    for (int frame = from; frame < std::min(now + 1, kFrames); ++frame) {
      late->save(saved[frame]);
      used[frame] = known[frame].value_or(frame > 0 ? used[frame - 1] : 0);  // the guess: nothing has changed
      step(*late, input(0, frame), used[frame]);
    }
    if (from >= now) continue;
    ++rollbacks;
    again += std::min(now, kFrames) - from;
    cost += Clock::now() - begin;
  }
  std::printf("%d rollbacks, each of %.1f steps, %.2f ms; a state has %zu bytes\n", rollbacks, 1.0 * again / rollbacks,
              cost.count() / rollbacks, saved[kFrames - 1].size());
  const bool same = late->state_hash() == on_time->state_hash();
  std::printf("the end has %s with all inputs on time\n", same ? "the same bits as" : "other bits than");
  return same && rollbacks > 0 ? 0 : 1;
}
