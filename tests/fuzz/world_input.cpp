// Bytes -> calls of a world; PSIM_FUZZ_TALK=1 in the environment prints them. In tame inputs all numbers are sane but the NaN that bodies are given on
// purpose, and the reports must count exactly those.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "byte_source.h"
#include "inputs.h"
#include "psim/psim.h"
#include "world_promises.h"

namespace psim::fuzz {
namespace {

constexpr double kHalf = 12;  // m: bodies are placed within, whatever the bounds
constexpr std::size_t kMostBodies = 120, kMostJoints = 80;
constexpr int kMostSteps = 50;

struct Fault {
  std::string what;
};

void require(bool holds, const std::string& what) {
  if (!holds) throw Fault{what};
}

template <class T, std::size_t N>
T one_of(ByteSource& in, const T (&values)[N]) {
  return values[in.below(N)];
}

class Session {
 public:
  explicit Session(Bytes calls) : in_(calls) {}

  void run() {
    if (!create()) return;
    while (!in_.empty() && steps_ < kMostSteps) {
      call();
      if (restores_) replace_last();
    }
    step(worlds_.front()->desc().dt);
  }

 private:
  // What the worlds must know, too.
  struct Known {
    std::vector<BodyId> bodies, dead;
    std::vector<JointId> joints;
    std::set<std::uint32_t> broken;  // given NaN since the last step
    bool maybe_broken = false, jointed = false;
  };

  using Worlds = std::vector<std::unique_ptr<World>>;

  // ---- worlds -----------------------------------------------------------------------------------

  bool create() {
    const int kind = in_.byte();
    in_.tame = (kind & 1) != 0;
    restores_ = (kind & 12) == 12;
    const bool twins = (kind & 2) != 0 || restores_;
    WorldDesc d = world();
    RunOptions o{one_of(in_, kAllIsas), one_of(in_, {1, 1, 1, 1, 1, 1, 2, 3})};
    if (!in_.tame && in_.chance(4)) o.threads = in_.byte() - 10;
    if (!isa_available(o.isa)) o.isa = best_isa();
    say("world %s boundary %d bounds %g %g %g %g gravity %g %g damping %g wall %g %g fields %zu dt "
        "%g substeps %d "
        "integrator %d threshold %g sleeping %d isa %d threads %d%s",
        in_.tame ? "tame" : "wild", static_cast<int>(d.boundary), d.bounds.xmin, d.bounds.ymin,
        d.bounds.xmax, d.bounds.ymax, d.gravity.x, d.gravity.y, d.linear_damping,
        d.wall.restitution, d.wall.friction, d.fields.size(), d.dt, d.substeps,
        static_cast<int>(d.integrator), d.restitution_threshold, d.sleeping,
        static_cast<int>(o.isa), o.threads,
        restores_ ? " restored after each call"
        : twins   ? " twins"
                  : "");
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
    open_ = d.boundary == Boundary::open;
    return true;
  }

  WorldDesc world() {
    WorldDesc d;
    d.boundary = one_of(in_, {Boundary::walls, Boundary::periodic, Boundary::open});
    const double half = one_of(in_, {kHalf, 30.0, 500.0, 1e6});
    d.bounds = {-half, -half, half, one_of(in_, {half, 2 * half})};
    if (!in_.tame && in_.chance(10)) {
      const Vec2 low = in_.vec2(-kHalf, 0), high = in_.vec2(0, kHalf);
      d.bounds = {low.x, low.y, high.x, high.y};
    }
    d.gravity = one_of(in_, {Vec2{0, -9.81}, Vec2{0, 0}, Vec2{3, 40}});
    if (in_.chance(10)) d.gravity = in_.vec2(-50, 50);
    if (in_.chance(30)) d.linear_damping = in_.number(0, 3);
    d.wall = material();
    while (in_.chance(40) && d.fields.size() < 3) d.fields.push_back(field());
    d.dt = one_of(in_, {1.0 / 60, 1.0 / 60, 1.0 / 30, 1.0 / 240});
    if (!in_.tame && in_.chance(10)) d.dt = in_.number(1e-4, 0.2);
    d.substeps = one_of(in_, {4, 4, 1, 8});
    if (!in_.tame && in_.chance(10)) d.substeps = in_.byte() - 2;
    d.integrator = one_of(in_, kAllIntegrators);
    if (in_.chance(20)) d.restitution_threshold = in_.number(0, 2);
    d.sleeping = !in_.chance(64);
    return d;
  }

  Field field() {
    if (in_.chance(100)) return DragField{in_.number(0, 2), in_.number(0, 0.5)};
    WellField well;
    well.position = in_.vec2(-kHalf, kHalf);
    well.strength = in_.number(-200, 200);
    well.softening = in_.number(0.2, 2);
    well.exponent = one_of(in_, {2.0, 1.0, 0.0, 2.5});
    well.range = in_.chance(128) ? 0 : in_.number(0, 20);
    return well;
  }

  Material material() {
    Material m;
    m.density = in_.number(0.2, 5);
    m.restitution = in_.chance(128) ? 0 : in_.number(0, 1);
    m.friction = in_.chance(128) ? 0 : in_.number(0, 1.5);
    return m;
  }

  // ---- bodies -----------------------------------------------------------------------------------

  Shape shape() {
    const double size = one_of(in_, {0.5, 0.5, 0.2, 1.0, 3.0});
    switch (in_.below(8)) {
      case 0:
        return SegmentShape{in_.vec2(-size, size), in_.vec2(-size, size)};
      case 1: {
        ChainShape chain;
        const std::size_t n = in_.below(9);
        for (std::size_t k = 0; k < n; ++k) chain.vertices.push_back(in_.vec2(-2 * size, 2 * size));
        chain.loop = in_.chance(100);
        return chain;
      }
      case 2:
        return BoxShape{in_.number(0.1, size), in_.number(0.1, size),
                        in_.chance(50) ? in_.number(0, 0.3) : 0};
      case 3: {
        PolygonShape polygon;
        const std::size_t n = in_.below(11);
        const double phase = in_.uniform(0, 6), r = in_.number(0.2, size);
        for (std::size_t k = 0; k < n; ++k) {
          const double a =
              phase + 6.283185307179586 * static_cast<double>(k) / static_cast<double>(n);
          polygon.vertices.push_back({r * std::cos(a), r * std::sin(a)});
        }
        if (n > 0 && in_.chance(30)) polygon.vertices[in_.below(n)] = in_.vec2(-size, size);
        if (in_.chance(40)) polygon.radius = in_.number(0, 0.2);
        return polygon;
      }
      case 4:
        return CapsuleShape{in_.vec2(-size, size), in_.vec2(-size, size), in_.number(0.05, size)};
      default:
        return DiscShape{in_.number(0.1, size)};
    }
  }

  Filter filter() {
    Filter f;
    if (!in_.chance(20)) return f;
    f.category = 1u << in_.below(8);
    f.mask = in_.byte();
    f.group = static_cast<std::int32_t>(in_.below(5)) - 2;
    return f;
  }

  BodyDesc body() {
    BodyDesc d;
    d.type = one_of(in_, {BodyType::dynamic_body, BodyType::dynamic_body, BodyType::dynamic_body,
                          BodyType::static_body, BodyType::kinematic_body});
    d.shape = in_.chance(128) ? Shape(DiscShape{in_.number(0.1, 0.6)}) : shape();
    d.position = in_.vec2(-kHalf, kHalf);
    if (in_.chance(80)) d.angle = in_.number(-4, 4);
    if (in_.chance(128)) d.velocity = in_.vec2(-20, 20);
    if (in_.chance(40)) d.angular_velocity = in_.number(-20, 20);
    if (in_.chance(80)) d.material = material();
    if (in_.chance(30)) d.mass = in_.number(0, 100);
    if (in_.chance(20)) d.gravity_scale = in_.number(-1, 2);
    d.fixed_rotation = in_.chance(10);
    d.bullet = in_.chance(16);
    d.sensor = in_.chance(16);
    d.filter = filter();
    return d;
  }

  void add_body() {
    if (bodies_.size() >= kMostBodies) return;
    const BodyDesc d = body();
    const BodyId id = same<BodyId>("add_body", [&](World& w) {
      std::string error;
      const BodyId got = w.add_body(d, error);
      require((got == kNoBody) != error.empty(), "add_body: an id or an error");
      if (got == kNoBody) refused(error);
      return got;
    });
    say("body %u type %d shape %zu at %g %g angle %g velocity %g %g %g mass %g density %g "
        "restitution %g friction %g "
        "scale %g%s%s%s filter %x %x %d",
        id.index, static_cast<int>(d.type), d.shape.index(), d.position.x, d.position.y, d.angle,
        d.velocity.x, d.velocity.y, d.angular_velocity, d.mass, d.material.density,
        d.material.restitution, d.material.friction, d.gravity_scale,
        d.fixed_rotation ? " upright" : "", d.bullet ? " bullet" : "", d.sensor ? " sensor" : "",
        d.filter.category, d.filter.mask, d.filter.group);
    if (id != kNoBody) live(id);
  }

  void add_discs() {
    const std::size_t n = in_.below(30);
    if (bodies_.size() + n > kMostBodies) return;
    std::vector<double> x, y, radius{in_.number(0.1, 0.6)}, vx, more;
    const Vec2 at = in_.vec2(-kHalf, kHalf / 2);
    for (std::size_t k = 0; k < n; ++k) {
      x.push_back(at.x + 0.7 * static_cast<double>(k % 5));
      y.push_back(at.y + 0.7 * static_cast<double>(k / 5));
    }
    if (in_.chance(60)) {
      while (radius.size() < n) radius.push_back(in_.number(0.1, 0.5));
    }
    if (in_.chance(60)) vx.assign(n, in_.number(-5, 5));
    if (in_.chance(16)) more.assign(in_.below(30), in_.number(-5, 5));
    DiscBatch batch;
    batch.x = x;
    batch.y = y;
    batch.radius = radius;
    batch.vx = vx;
    batch.angular_velocity = more;
    batch.type = in_.chance(200) ? BodyType::dynamic_body
                                 : one_of(in_, {BodyType::static_body, BodyType::kinematic_body});
    if (in_.chance(60)) batch.material = material();
    if (in_.chance(30)) batch.mass = in_.number(0, 20);
    if (in_.chance(20)) batch.gravity_scale = in_.number(-1, 2);
    batch.bullet = in_.chance(10);
    batch.filter = filter();
    say("discs %zu at %g %g radius %g vx %g type %d mass %g bullet %d", n, at.x, at.y, radius[0],
        vx.empty() ? 0 : vx[0], static_cast<int>(batch.type), batch.mass, batch.bullet);
    const auto before = worlds_.front()->body_count();
    const std::size_t added = same<std::size_t>("add_discs", [&](World& w) {
      std::string error;
      std::uint32_t first = 0;
      const std::size_t got = w.add_discs(batch, first, error);
      require(got == (error.empty() ? n : 0),
              "add_discs: all or none, and then an error: " + error);
      if (!error.empty()) refused(error);
      return got;
    });
    require(worlds_.front()->body_count() == before + added, "add_discs: the count");
    const PublishedState s = worlds_.front()->published();
    for (const std::uint32_t index : s.id) live(worlds_.front()->id_of(index));
  }

  void live(BodyId id) {
    if (std::find(bodies_.begin(), bodies_.end(), id) == bodies_.end()) bodies_.push_back(id);
  }

  // One that lives, one that is gone, or nonsense.
  BodyId some_body() {
    if (bodies_.empty() || in_.chance(8)) {
      if (!dead_.empty() && in_.chance(160))
        return dead_[in_.below(std::min<std::size_t>(dead_.size(), 256))];
      return {static_cast<std::uint32_t>(in_.byte()) << (in_.below(4) * 8), in_.byte()};
    }
    return bodies_[in_.below(std::min<std::size_t>(bodies_.size(), 256))];
  }

  void remove_body() {
    const BodyId id = some_body();
    const bool lives = is_live(id);
    say("remove %u", id.index);
    require(same<bool>("remove_body", [&](World& w) { return w.remove_body(id); }) == lives,
            "remove_body: true for the living");
    if (lives) bury(id);
  }

  void bury(BodyId id) {
    std::erase(bodies_, id);
    dead_.push_back(id);
    broken_.erase(id.index);
    require(!worlds_.front()->is_valid(id), "a removed body is valid");
  }

  bool is_live(BodyId id) const {
    return std::find(bodies_.begin(), bodies_.end(), id) != bodies_.end();
  }

  void move_body() {
    const BodyId id = some_body();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const bool breaks = in_.chance(6);
    const Vec2 v = breaks ? Vec2{nan, 0} : in_.vec2(-kHalf, kHalf);
    const double turn = in_.chance(100) ? in_.number(-10, 10) : 0;
    const Vec2 at = in_.vec2(-kHalf, kHalf);
    const std::size_t which = in_.below(5);
    say("move %u by %zu: %g %g turn %g at %g %g", id.index, which, v.x, v.y, turn, at.x, at.y);
    const bool moved = same<bool>("moving a body", [&](World& w) {
      switch (which) {
        case 0:
          return w.set_transform(id, v, turn);
        case 1:
          return w.set_velocity(id, v, turn);
        case 2:
          return w.apply_impulse(id, v);
        case 3:
          return w.apply_impulse_at(id, v, at);
        default:
          return w.apply_angular_impulse(id, breaks ? nan : turn);
      }
    });
    require(!moved || is_live(id), "a body that is not there was moved");
    if (moved && breaks) broken_.insert(id.index);
    if (moved && breaks && which == 4) maybe_broken_ = true;  // one that cannot turn takes no harm
  }

  // ---- joints -----------------------------------------------------------------------------------

  void add_joint() {
    if (joints_.size() >= kMostJoints) return;
    JointDesc d;
    d.type = static_cast<JointType>(in_.below(6));
    d.a = some_body();
    d.b = some_body();
    d.anchor_a = in_.chance(128) ? Vec2{} : in_.vec2(-1, 1);
    d.anchor_b = in_.chance(128) ? Vec2{} : in_.vec2(-1, 1);
    if (in_.chance(80)) d.length = in_.number(0, 4);
    if (in_.chance(80)) d.stiffness = in_.number(0, 500);
    if (in_.chance(80)) d.damping = in_.number(0, 20);
    if (in_.chance(80)) d.axis = in_.vec2(-1, 1);
    if (in_.chance(30)) d.reference = in_.number(-3, 3);
    if (in_.chance(60)) d.lower = in_.number(-2, 0);
    if (in_.chance(60)) d.upper = in_.number(0, 2);
    if (in_.chance(60)) d.motor_speed = in_.number(-10, 10), d.motor_limit = in_.number(0, 200);
    d.collide = in_.chance(60);
    const JointId id = same<JointId>("add_joint", [&](World& w) {
      std::string error;
      const JointId got = w.add_joint(d, error);
      require((got == kNoJoint) != error.empty(), "add_joint: an id or an error");
      if (got == kNoJoint) refused(error);
      return got;
    });
    say("joint %u type %d of %u and %u%s", id.index, static_cast<int>(d.type), d.a.index, d.b.index,
        d.collide ? " colliding" : "");
    if (id == kNoJoint) return;
    require(is_live(d.a) && is_live(d.b), "a joint on a body that is not there");
    joints_.push_back(id);
    jointed_ = true;
  }

  JointId some_joint() {
    if (joints_.empty() || in_.chance(16)) return {in_.byte(), in_.byte()};
    return joints_[in_.below(joints_.size())];
  }

  void touch_joint() {
    const JointId id = some_joint();
    const std::size_t which = in_.below(3);
    const double speed = in_.number(-10, 10), limit = in_.number(0, 100);
    const bool valid = worlds_.front()->is_valid_joint(id);
    say("change joint %u by %zu", id.index, which);
    const bool did = same<bool>("changing a joint", [&](World& w) {
      if (which == 0) return w.remove_joint(id);
      if (which == 1) return w.set_motor(id, speed, limit);
      const auto state = w.joint(id);
      if (state) require(w.is_valid(state->a) && w.is_valid(state->b), "a joint of no bodies");
      return state.has_value();
    });
    require(!did || valid, "a joint that is not there was changed");
    require(which == 1 || did == valid, "a joint that is there was refused");
    if (which == 0 && did) std::erase(joints_, id);
  }

  // ---- questions --------------------------------------------------------------------------------

  void ask() {
    QueryFilter f;
    if (in_.chance(40))
      f = {in_.byte(), in_.chance(128), in_.chance(128), in_.chance(128), in_.chance(128)};
    const Vec2 p = in_.vec2(-2 * kHalf, 2 * kHalf), q = in_.vec2(-2 * kHalf, 2 * kHalf);
    const std::size_t which = in_.below(4);
    const double more = in_.number(0, 10);
    const Shape outline = which == 1 ? shape() : Shape(DiscShape{});
    say("ask %zu: %g %g to %g %g, %g", which, p.x, p.y, q.x, q.y, more);
    const std::string answer = same<std::string>("a question", [&](World& w) {
      switch (which) {
        case 0:
          return ray_answer(w, p, q, f);
        case 1:
          return bodies_answer(w, w.overlap(outline, p, more, f));
        case 2:
          return bodies_answer(w, w.in_region({p.x, p.y, q.x, q.y}, f));
        default:
          return closest_answer(w, p, more, f);
      }
    });
    require(!answer.starts_with("fault"), answer);
  }

  // ---- steps ------------------------------------------------------------------------------------

  void step(double dt) {
    std::vector<StepReport> reports;
    say("step %d of %g s", steps_ + 1, dt);
    const std::uint64_t frame = worlds_.front()->frame();
    for (auto& w : worlds_) reports.push_back(w->step(dt));
    if (worlds_.front()->frame() == frame)
      return require(!(dt >= 1e-300 && dt <= 10), "step: a dt that is refused");
    require(dt > 0 && dt <= 10, "step: a dt that is accepted");
    stepped(reports);
  }

  void stepped(const std::vector<StepReport>& reports) {
    ++steps_;
    const StepReport& report = reports.front();
    World& world = *worlds_.front();
    for (std::size_t k = 1; k < worlds_.size(); ++k) {
      require(worlds_[k]->state_hash() == world.state_hash(), "two variants differ");
      const std::string one = report_answer(report), other = report_answer(reports[k]);
      require(one == other, "the reports of two variants differ: " + one + " and " + other);
      const std::string told = events_answer(world), told_too = events_answer(*worlds_[k]);
      require(told == told_too, "the events of two variants differ: " + told + " and " + told_too);
    }
    if (talks_) say_fastest(world);
    std::vector<BodyId> gone;
    for (const BodyId id : bodies_) {
      if (!world.is_valid(id)) gone.push_back(id);
    }
    require(gone.size() == report.escaped, "escaped bodies are those that are gone");
    require(gone.empty() || open_, "bodies escaped from a closed world");
    for (const BodyId id : gone) bury(id);
    // Joints that contradict each other can throw bodies out of all numbers.
    if (in_.tame && !maybe_broken_ && !jointed_) {
      require(report.quarantined == broken_.size(), "quarantined: those that were broken");
    }
    broken_.clear();
    maybe_broken_ = false;
    look();
  }

  void say_fastest(World& world) const {
    BodyState fastest;
    for (const BodyId id : bodies_) {
      const auto s = world.body(id);
      if (s && std::hypot(s->vx, s->vy) >= std::hypot(fastest.vx, fastest.vy)) fastest = *s;
    }
    say("  fastest: body %u at %g %g angle %g velocity %g %g %g", fastest.id.index, fastest.x,
        fastest.y, fastest.angle, fastest.vx, fastest.vy, fastest.omega);
  }

  void look() {
    World& world = *worlds_.front();
    require(world.body_count() == bodies_.size(), "body_count");
    std::erase_if(joints_, [&](JointId id) { return !world.is_valid_joint(id); });
    require(world.joint_count() == joints_.size(), "joint_count");
    for (auto& w : worlds_) {
      const std::string fault = broken_promise(*w);
      require(fault.empty(), fault);
    }
  }

  void replay() {
    StepDetail detail;
    detail.substeps = static_cast<std::uint8_t>(in_.below(in_.tame ? 9 : 256));
    detail.solves = in_.chance(128);
    detail.wakes = in_.chance(in_.tame ? 0 : 16);
    detail.pieces = static_cast<std::uint32_t>(in_.below(in_.tame ? 40 : 256));
    detail.frames = static_cast<std::uint8_t>(in_.tame ? 1 + in_.below(3) : in_.byte() % 10);
    detail.horizon = static_cast<std::uint8_t>(in_.tame ? 1 + in_.below(4) : in_.byte() % 10);
    // Of a byte that was read already: old inputs stay what they are.
    detail.sweeps = static_cast<std::uint8_t>(detail.pieces % 3 == 0 ? detail.pieces / 3 % (in_.tame ? 16 : 20) : 0);
    std::vector<StepReport> reports;
    say("step %d: substeps %d solves %d wakes %d pieces %d frames %d horizon %d sweeps %d", steps_ + 1, detail.substeps,
        detail.solves, detail.wakes, static_cast<int>(detail.pieces), detail.frames, detail.horizon, detail.sweeps);
    const std::uint64_t frame = worlds_.front()->frame();
    for (auto& w : worlds_) reports.push_back(w->replay(detail));
    const auto frames = [](int n) { return n >= 1 && n <= 8; };
    if (detail.substeps > 64 || !frames(detail.frames) || !frames(detail.horizon) ||
        (detail.solves && detail.wakes) || detail.sweeps > 15) {
      return require(worlds_.front()->frame() == frame,
                     "replay: a detail that no governor chooses");
    }
    stepped(reports);
  }

  // The last world goes into a state and out of it, at every second call as a world of its own, and must go on
  // like the one beside it that never did.
  void replace_last() {
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
    } else {
      require(w->restore(state, error), "restore: the state just saved: " + error);
    }
    require(w->state_hash() == hash, "restore: the hash of the state just saved");
  }

  // Into a state and out of it at once, or back to an older one: a world as it was then.
  void go_back() {
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
    for (std::size_t k = 0; k < worlds_.size(); ++k) {
      require(worlds_[k]->restore(kept_.states[k], error), "restore: " + error);
      require(worlds_[k]->state_hash() == kept_.hash, "restore: the hash");
    }
    known_ = kept_.known;
  }

  void govern() {
    GovernorDesc d;
    d.on = in_.chance(200);
    d.budget_ms = one_of(in_, {16.0, 0.01, 0.05, 1.0});
    if (in_.chance(60)) d.budget_ms = in_.number(0, 20);
    if (in_.chance(60)) d.costs.pass = in_.number(0, 1000);
    if (in_.chance(30)) d.costs.joint_pass = in_.number(0, 1000);
    say("governor %d budget %g pass %g joint %g", d.on, d.budget_ms, d.costs.pass,
        d.costs.joint_pass);
    const bool sane = d.budget_ms > 0 && std::isfinite(d.costs.pass) && d.costs.pass >= 0 &&
                      std::isfinite(d.costs.joint_pass) && d.costs.joint_pass >= 0;
    for (auto& w : worlds_) require(w->set_governor(d) == sane, "set_governor");
    if (sane) governor_ = d;
  }

  void change_options() {
    const std::size_t which = in_.below(8);
    const bool on = in_.chance(128);
    const Vec2 gravity = in_.vec2(-20, 20);
    const EventOptions events{in_.chance(200), in_.chance(200),
                              in_.chance(100) ? in_.number(0, 5) : 1, in_.chance(200)};
    const BodyId id = some_body();
    say("option %zu: %d, gravity %g %g, body %u", which, on, gravity.x, gravity.y, id.index);
    for (std::size_t k = 0; k < worlds_.size(); ++k) {
      World& w = *worlds_[k];
      switch (which) {
        case 0:
          require(w.set_gravity(gravity) == (std::isfinite(gravity.x) && std::isfinite(gravity.y)),
                  "set_gravity");
          break;
        case 1:
          w.set_sleeping(on);
          break;
        case 2:
          require(w.wake(id) == is_live(id), "wake");
          break;
        case 3:
          require(w.why_awake(id).find('\n') == std::string::npos, "why_awake: one line");
          break;
        case 4:
          w.set_event_options(events);
          break;
        case 5:
          w.enable_snapshots(snapshots_ = on);
          require(w.set_skin(gravity.x) == (gravity.x >= 0.25 && gravity.x <= 4), "set_skin");
          break;
        case 6:
          if (k == 0) w.set_job_system(on ? job_system() : JobSystem{});
          break;
        default:
          if (k == 0) on ? w.start_trace() : void(w.take_trace());
      }
    }
  }

  // From the last job to the first.
  static JobSystem job_system() {
    return {[](std::size_t count, const std::function<void(std::size_t)>& job) {
              for (std::size_t k = count; k > 0; --k) job(k - 1);
            },
            2};
  }

  void call() {
    const std::size_t kind = in_.below(16);
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
        return in_.chance(40)   ? govern()
               : in_.chance(40) ? replay()
                                : step(worlds_.front()->desc().dt);
      case 12:
        return step(in_.number(0.001, 0.05));
      case 13:
        if (in_.chance(20)) {
          say("%s", "prepare");
          for (auto& w : worlds_) w->prepare();
        } else if (in_.chance(80)) {
          go_back();
        }
        return look();
      default:
        for (std::size_t k = 1 + in_.below(3); k > 0; --k) step(worlds_.front()->desc().dt);
    }
  }

  // The same call on every world gives the same answer.
  template <class Answer, class Call>
  Answer same(const char* what, const Call& call) {
    const Answer first = call(*worlds_.front());
    for (std::size_t k = 1; k < worlds_.size(); ++k) {
      require(call(*worlds_[k]) == first, std::string(what) + ": two variants differ");
    }
    return first;
  }

  static void refused(const std::string& error) {
    require(!error.empty() && error.find('\n') == error.npos, "an error of one line: " + error);
  }

  template <class... Values>
  void say(const char* format, Values... values) const {
    if (!talks_) return;
    std::fprintf(stderr, format, values...);
    std::fputc('\n', stderr);
  }

  const bool talks_ = std::getenv("PSIM_FUZZ_TALK") != nullptr;
  ByteSource in_;
  Worlds worlds_;
  bool open_ = false, restores_ = false, snapshots_ = false;
  int replaced_ = 0;
  GovernorDesc governor_;
  int steps_ = 0;
  Known known_;
  std::vector<BodyId>&bodies_ = known_.bodies, &dead_ = known_.dead;
  std::vector<JointId>& joints_ = known_.joints;
  std::set<std::uint32_t>& broken_ = known_.broken;
  bool &maybe_broken_ = known_.maybe_broken, &jointed_ = known_.jointed;
  struct {
    std::vector<std::vector<std::byte>> states;  // by world
    std::uint64_t hash = 0;
    Known known;
  } kept_;
};

}  // namespace

std::string world_input(Bytes calls) {
  try {
    Session(calls).run();
  } catch (const Fault& fault) {
    return fault.what;
  }
  return {};
}

}  // namespace psim::fuzz
