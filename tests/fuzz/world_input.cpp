// Bytes -> calls of a world; PSIM_FUZZ_TALK=1 in the environment prints them. In tame inputs all
// numbers are sane but the NaN that bodies are given on purpose, and the reports must count exactly
// those.
#include "inputs.h"

#include <string>
#include <utility>
#include <vector>

#include "world_descs.h"
#include "world_promises.h"
#include "world_session.h"

namespace psim::fuzz {
namespace {

constexpr int kMostSteps = 50;
// An input of a few bodies may take all its steps; one of thousands of bodies takes few. Half a second with sanitizers.
constexpr std::uint64_t kMostWork = 40'000;

// Numbers of threads that no world accepts, and a few that it does: hundreds would only fight for the processor.
int refused_or_few(int threads) { return threads > 8 ? threads % 2 == 0 ? 8 : 257 : threads; }

}  // namespace

void Session::run() {
  if (!create()) return;
  while (!in_.empty() && !spent()) {
    call();
    if (over_) return;
    if (restores_) replace_last();
  }
  step(worlds_.front()->desc().dt);
  look(true);
  end_recording();
  say("%d steps, work %llu", steps_, static_cast<unsigned long long>(work_));
}

bool Session::spent() const { return over_ || steps_ >= kMostSteps || work_ >= kMostWork; }

bool Session::create() {
  const int kind = in_.byte();
  in_.tame = (kind & 1) != 0;
  restores_ = (kind & 12) == 12;
  const bool twins = (kind & 2) != 0 || restores_;
  in_.rich = kind >= 16;
  if (in_.rich) {
    most_bodies_ = one_of<std::size_t>(in_, {120, 120, 120, 120, 120, 400, 400, 3000});
    most_joints_ = 1000;
    in_.home = one_of(in_, {Vec2{}, Vec2{}, Vec2{}, Vec2{1000, -300}, Vec2{1e5, 1e5}, Vec2{-3e6, 2e6}});
  }
  WorldDesc d = world(in_);
  RunOptions o{one_of(in_, kAllIsas), one_of(in_, {1, 1, 1, 1, 1, 1, 2, 3})};
  if (!in_.tame && in_.chance(4)) o.threads = refused_or_few(in_.byte() - 10);
  if (!isa_available(o.isa)) o.isa = best_isa();
  say("world %s boundary %d bounds %g %g %g %g gravity %g %g damping %g wall %g %g fields %zu dt "
      "%g substeps %d "
      "integrator %d threshold %g sleeping %d isa %d threads %d%s",
      in_.tame ? "tame" : "wild", static_cast<int>(d.boundary), d.bounds.xmin, d.bounds.ymin, d.bounds.xmax,
      d.bounds.ymax, d.gravity.x, d.gravity.y, d.linear_damping, d.wall.restitution, d.wall.friction, d.fields.size(),
      d.dt, d.substeps, static_cast<int>(d.integrator), d.restitution_threshold, d.sleeping, static_cast<int>(o.isa),
      o.threads,
      restores_ ? " restored after each call"
      : twins   ? " twins"
                : "");
  open_ = d.boundary == Boundary::open;
  if (in_.rich && in_.chance(48)) return create_from_scene(d, o, twins);
  for (int k = 0; k < (twins ? 2 : 1); ++k) {
    std::string error;
    worlds_.push_back(World::create(d, o, error));
    require((worlds_.back() != nullptr) == error.empty(), "create: a world or an error");
    if (!worlds_.back()) {
      refused(error);
      return false;
    }
    o = {Isa::scalar, 1};
  }
  return true;
}

void Session::call() {
  const std::size_t kind = in_.below(in_.rich ? 32 : 16);
  switch (kind) {
    case 0:
    case 1:
    case 2:
      return add_body();
    case 3:
      return add_discs();
    case 4:
      return remove_body();
    case 5:
    case 6:
      return move_body();
    case 7:
      return add_joint();
    case 8:
      return touch_joint();
    case 9:
      return ask();
    case 10:
      return change_options();
    case 11:
      return in_.chance(40) ? govern() : in_.chance(40) ? replay({}) : step(worlds_.front()->desc().dt);
    case 12:
      return step(in_.number(0.001, 0.05));
    case 13:
      if (in_.chance(20)) {
        say("%s", "prepare");
        worlds_.back()->prepare();  // of two the other does without
      } else if (in_.chance(80)) {
        go_back();
      }
      return look(true);
    case 14:
    case 15:
      for (std::size_t k = 1 + in_.below(3); k > 0 && !spent(); --k) step(worlds_.front()->desc().dt);
      return;
    default:
      return call_rich(kind);
  }
}

void Session::call_rich(std::size_t kind) {
  switch (kind) {
    case 16:
    case 17:
      return add_pile();
    case 18:
      return add_net();
    case 19:
      return add_terrain();
    case 20:
      return add_giant();
    case 21:
      return add_kinematic();
    case 22:
      return add_tower();
    case 23:
      return in_.chance(40) ? remove_many() : push_many();
    case 24:
      return start_recording();
    case 25:
      return end_recording();
    case 26:
      return starve();
    case 27:
      return count();
    case 28:
      return replay(in_.number(0.001, 0.05));
    case 31:
      return in_.chance(128) ? pour() : touch_taps();
    default:
      for (std::size_t k = 1 + in_.below(6); k > 0 && !spent(); --k) step(worlds_.front()->desc().dt);
  }
}

void Session::ask() {
  QueryFilter f;
  if (in_.chance(40))
    f = {in_.byte(),
         in_.chance(128),
         in_.chance(128),
         in_.chance(128),
         in_.chance(128),
         in_.chance(200) ? 0xFFFFFFFFu : in_.byte(),
         {},
         in_.chance(60),
         in_.chance(60)};
  const Vec2 p = in_.place(-2 * kHalf, 2 * kHalf), q = in_.place(-2 * kHalf, 2 * kHalf);
  const std::size_t which = in_.below(7);
  const double more = in_.number(0, 10);
  const Shape outline = which == 1 || which == 4 || which == 5 ? shape(in_) : Shape(DiscShape{});
  say("ask %zu: %g %g to %g %g, %g", which, p.x, p.y, q.x, q.y, more);
  const std::string answer = same<std::string>("a question", [&](World& w) {
    switch (which) {
      case 0:
        return ray_answer(w, p, q, f);
      case 1:
        return bodies_answer(w, w.overlap(outline, p, more, f));
      case 2:
        return bodies_answer(w, w.in_region({p.x, p.y, q.x, q.y}, f));
      case 4:
        return cast_answer(w, outline, p, more, {q.x - p.x, q.y - p.y}, f.dynamic ? 0 : more, f);
      case 5:
        return near_answer(w, outline, p, more, f);
      case 6:
        return mover_answer(w, p, q, f);
      default:
        return closest_answer(w, p, more, f);
    }
  });
  require(!answer.starts_with("fault"), answer);
}

// The last world goes into a state and out of it, at every second call as a world of its own, and must go on
// like the one beside it that never did.
void Session::replace_last() {
  end_recording();
  std::string error;
  std::vector<std::byte> state;
  std::unique_ptr<World>& w = worlds_.back();
  const std::uint64_t hash = w->state_hash();
  w->save(state);
  if (++replaced_ % 2 == 0) {
    w = World::from_state(state, {isa_available(Isa::sse) ? Isa::sse : Isa::scalar, 1}, error);
    require(w != nullptr, "from_state: the state just saved: " + error);
    w->set_governor(governor_);
    w->enable_snapshots(snapshots_);
    w->set_pre_solve(worlds_.front()->pre_solve());
  } else {
    const bool restored = w->restore(state, error);
    require(restored, "restore: the state just saved: " + error);
  }
  require(w->state_hash() == hash, "restore: the hash of the state just saved");
}

// Into a state and out of it at once, or back to an older one: a world as it was then.
void Session::go_back() {
  std::string error;
  const std::size_t which = in_.below(3);
  say("saved state %zu", which);
  if (which == 0) return replace_last();
  if (which == 1 || kept_.states.empty()) {
    kept_ = {};
    kept_.known = known_;
    for (auto& w : worlds_) {
      kept_.states.emplace_back();
      w->save(kept_.states.back());
      kept_.hash = w->state_hash();
    }
    return;
  }
  end_recording();
  for (std::size_t k = 0; k < worlds_.size(); ++k) {
    require(worlds_[k]->restore(kept_.states[k], error), "restore: " + error);
    require(worlds_[k]->state_hash() == kept_.hash, "restore: the hash");
  }
  known_ = kept_.known;
}

std::string world_input(Bytes calls) {
  try {
    Session(calls).run();
  } catch (const Fault& fault) {
    return fault.what;
  }
  return {};
}

}  // namespace psim::fuzz
