#include "psim/recording.h"

#include "archive.h"
#include "image.h"

namespace psim {
namespace {

enum class Op : std::uint8_t {
  step,  // dt, detail
  hash,
  add_body,
  add_discs,
  remove_body,
  set_transform,
  set_velocity,
  apply_impulse,
  apply_impulse_at,
  apply_angular_impulse,
  set_gravity,
  set_sleeping,
  wake,
  add_joint,
  remove_joint,
  set_motor,
  set_skin,
};

struct RecordHeader {
  static constexpr std::uint64_t kMagic = 0x31304352'6D697370u;  // "psimRC01"
  static constexpr std::uint64_t kFormat = 4;
  std::uint64_t magic = kMagic;
  std::uint64_t format = kFormat;
  std::uint64_t size = 0;   ///< of all, bytes
  std::uint64_t hash = 0;   ///< of what follows the header, and of the steps
  std::uint64_t state = 0;  ///< bytes of the state that it began with
  std::uint64_t steps = 0;

  std::uint64_t hash_with(std::span<const std::byte> rest) const {
    return hash_of(rest.data(), rest.size()) + 0x9E3779B97F4A7C15u * steps;
  }
};

template <class A>
void visit(A& a, Vec2& v) {
  numbers(a, v.x, v.y);
}
template <class A>
void visit(A& a, StepDetail& d) {
  numbers(a, d.substeps, d.solves, d.frames, d.horizon, d.pieces, d.wakes, d.sweeps);
}
template <class A>
void visit(A& a, JointId& id) {
  numbers(a, id.index, id.generation);
}
template <class A>
void visit(A& a, Material& m) {
  numbers(a, m.density, m.restitution, m.friction);
}
template <class A>
void visit(A& a, Filter& f) {
  numbers(a, f.category, f.mask, f.group);
}

template <class A>
void visit(A& a, Shape& shape) {
  auto which = static_cast<std::uint8_t>(shape.index());
  a.value(which);
  if constexpr (A::kLoading) {
    switch (which) {
      case 1: shape = SegmentShape{}; break;
      case 2: shape = ChainShape{}; break;
      case 3: shape = BoxShape{}; break;
      case 4: shape = PolygonShape{}; break;
      case 5: shape = CapsuleShape{}; break;
      default: shape = DiscShape{};
    }
  }
  const auto vertices = [&](std::vector<Vec2>& v) { list(a, v, [&](Vec2& p) { visit(a, p); }); };
  if (auto* disc = std::get_if<DiscShape>(&shape)) {
    a.value(disc->radius);
  } else if (auto* segment = std::get_if<SegmentShape>(&shape)) {
    visit(a, segment->p1);
    visit(a, segment->p2);
  } else if (auto* chain = std::get_if<ChainShape>(&shape)) {
    vertices(chain->vertices);
    a.value(chain->loop);
  } else if (auto* box = std::get_if<BoxShape>(&shape)) {
    numbers(a, box->width, box->height, box->radius);
  } else if (auto* polygon = std::get_if<PolygonShape>(&shape)) {
    vertices(polygon->vertices);
    a.value(polygon->radius);
  } else if (auto* capsule = std::get_if<CapsuleShape>(&shape)) {
    visit(a, capsule->p1);
    visit(a, capsule->p2);
    a.value(capsule->radius);
  }
}

template <class A>
void visit(A& a, BodyDesc& d) {
  a.value(d.type);
  visit(a, d.shape);
  visit(a, d.position);
  a.value(d.angle);
  visit(a, d.velocity);
  a.value(d.angular_velocity);
  visit(a, d.material);
  numbers(a, d.mass, d.gravity_scale, d.fixed_rotation, d.bullet, d.sensor);
  visit(a, d.filter);
}

// What a DiscBatch looks at.
struct Discs {
  std::vector<double> x, y, radius, angle, vx, vy, angular_velocity;
};

template <class A>
void visit(A& a, DiscBatch& b, Discs& discs) {
  const auto column = [&](std::span<const double>& seen, std::vector<double>& own) {
    if constexpr (!A::kLoading) own.assign(seen.begin(), seen.end());
    list(a, own, [&](double& v) { a.value(v); });
    seen = own;
  };
  column(b.x, discs.x);
  column(b.y, discs.y);
  column(b.radius, discs.radius);
  column(b.angle, discs.angle);
  column(b.vx, discs.vx);
  column(b.vy, discs.vy);
  column(b.angular_velocity, discs.angular_velocity);
  a.value(b.type);
  visit(a, b.material);
  numbers(a, b.mass, b.gravity_scale, b.fixed_rotation, b.bullet);
  visit(a, b.filter);
}

template <class A, class T>
void visit_any(A& a, T& v) {
  if constexpr (Number<T>) {
    a.value(v);
  } else if constexpr (std::is_same_v<T, BodyId> || std::is_same_v<T, JointDesc>) {
    Image::visit(a, v);
  } else {
    visit(a, v);
  }
}

}  // namespace

// ---- recorder --------------------------------------------------------------------------------------

struct Recorder::Log {
  std::vector<std::byte> state;
  Saver saver;
  std::uint64_t every = 60, steps = 0;

  template <class... T>
  void add(Op op, T... args) {
    saver.value(op);
    (visit_any(saver, args), ...);
  }
};

Recorder::Recorder(World& world, std::uint64_t every) : world_(world), log_(std::make_unique<Log>()) {
  log_->every = std::max<std::uint64_t>(every, 1);
  world.save(log_->state);
}
Recorder::~Recorder() = default;

StepReport Recorder::step() { return step(world_.desc().dt); }

StepReport Recorder::step(double dt) {
  const std::uint64_t frame = world_.frame();
  const StepReport report = world_.step(dt);
  if (world_.frame() == frame) return report;  // refused
  log_->add(Op::step, dt, report.detail);
  if (++log_->steps % log_->every == 0) log_->add(Op::hash, world_.state_hash());
  return report;
}

StepReport Recorder::replay(const StepDetail& detail) { return replay(detail, world_.desc().dt); }

StepReport Recorder::replay(const StepDetail& detail, double dt) {
  const std::uint64_t frame = world_.frame();
  const StepReport report = world_.replay(detail, dt);
  if (world_.frame() == frame) return report;  // refused
  log_->add(Op::step, dt, report.detail);
  if (++log_->steps % log_->every == 0) log_->add(Op::hash, world_.state_hash());
  return report;
}

BodyId Recorder::add_body(const BodyDesc& desc, std::string& error) {
  const BodyId id = world_.add_body(desc, error);
  if (id != kNoBody) log_->add(Op::add_body, desc);
  return id;
}

std::size_t Recorder::add_discs(const DiscBatch& batch, std::uint32_t& first, std::string& error) {
  const std::size_t added = world_.add_discs(batch, first, error);
  if (added == 0) return 0;
  DiscBatch copy = batch;
  Discs discs;
  log_->add(Op::add_discs);
  visit(log_->saver, copy, discs);
  return added;
}

bool Recorder::remove_body(BodyId id) {
  log_->add(Op::remove_body, id);
  return world_.remove_body(id);
}
bool Recorder::set_transform(BodyId id, Vec2 position, double angle) {
  log_->add(Op::set_transform, id, position, angle);
  return world_.set_transform(id, position, angle);
}
bool Recorder::set_velocity(BodyId id, Vec2 velocity, double angular_velocity) {
  log_->add(Op::set_velocity, id, velocity, angular_velocity);
  return world_.set_velocity(id, velocity, angular_velocity);
}
bool Recorder::apply_impulse(BodyId id, Vec2 impulse) {
  log_->add(Op::apply_impulse, id, impulse);
  return world_.apply_impulse(id, impulse);
}
bool Recorder::apply_impulse_at(BodyId id, Vec2 impulse, Vec2 point) {
  log_->add(Op::apply_impulse_at, id, impulse, point);
  return world_.apply_impulse_at(id, impulse, point);
}
bool Recorder::apply_angular_impulse(BodyId id, double impulse) {
  log_->add(Op::apply_angular_impulse, id, impulse);
  return world_.apply_angular_impulse(id, impulse);
}
bool Recorder::set_gravity(Vec2 gravity) {
  log_->add(Op::set_gravity, gravity);
  return world_.set_gravity(gravity);
}
bool Recorder::set_skin(double factor) {
  log_->add(Op::set_skin, factor);
  return world_.set_skin(factor);
}
void Recorder::set_sleeping(bool on) {
  log_->add(Op::set_sleeping, on);
  world_.set_sleeping(on);
}
bool Recorder::wake(BodyId id) {
  log_->add(Op::wake, id);
  return world_.wake(id);
}
JointId Recorder::add_joint(const JointDesc& desc, std::string& error) {
  const JointId id = world_.add_joint(desc, error);
  if (id != kNoJoint) log_->add(Op::add_joint, desc);
  return id;
}
bool Recorder::remove_joint(JointId id) {
  log_->add(Op::remove_joint, id);
  return world_.remove_joint(id);
}
bool Recorder::set_motor(JointId id, double speed, double limit) {
  log_->add(Op::set_motor, id, speed, limit);
  return world_.set_motor(id, speed, limit);
}

std::vector<std::byte> Recorder::recording() const {
  Log end;
  end.add(Op::hash, world_.state_hash());
  const auto ops = log_->saver.first(), last = end.saver.first();
  RecordHeader header;
  header.state = log_->state.size();
  header.steps = log_->steps;
  header.size = sizeof header + log_->state.size() + ops.size() + last.size();
  std::vector<std::byte> out(sizeof header);
  out.reserve(header.size);
  out.insert(out.end(), log_->state.begin(), log_->state.end());
  out.insert(out.end(), ops.begin(), ops.end());
  out.insert(out.end(), last.begin(), last.end());
  header.hash = header.hash_with(std::span(out).subspan(sizeof header));
  std::memcpy(out.data(), &header, sizeof header);
  return out;
}

// ---- replay ----------------------------------------------------------------------------------------

struct Replay::State {
  std::vector<std::byte> bytes;  // of the log
  std::unique_ptr<World> world;
  std::optional<Loader> log;
  std::uint64_t steps = 0, in_all = 0, hashes = 0, differs = 0;
  bool compared = false;  // the present state

  template <class T>
  T get() {
    T v{};
    visit_any(*log, v);
    return v;
  }
  void check() {
    const auto hash = get<std::uint64_t>();
    if (!log->ok()) return;
    ++hashes;
    compared = true;
    if (differs == 0 && hash != world->state_hash()) differs = std::max<std::uint64_t>(steps, 1);
  }
  bool perform(Op op);
};

// False after a step.
bool Replay::State::perform(Op op) {
  World& w = *world;
  std::string error;
  compared = false;
  switch (op) {
    case Op::step: {
      const auto dt = get<double>();
      const auto detail = get<StepDetail>();
      if (!log->ok()) return false;
      w.replay(detail, dt);
      ++steps;
      return false;
    }
    case Op::hash: check(); break;
    case Op::add_body: w.add_body(get<BodyDesc>(), error); break;
    case Op::add_discs: {
      DiscBatch batch;
      Discs discs;
      visit(*log, batch, discs);
      std::uint32_t first = 0;
      w.add_discs(batch, first, error);
      break;
    }
    case Op::remove_body: w.remove_body(get<BodyId>()); break;
    case Op::set_transform: {
      const auto id = get<BodyId>();
      const auto position = get<Vec2>();
      w.set_transform(id, position, get<double>());
      break;
    }
    case Op::set_velocity: {
      const auto id = get<BodyId>();
      const auto velocity = get<Vec2>();
      w.set_velocity(id, velocity, get<double>());
      break;
    }
    case Op::apply_impulse: {
      const auto id = get<BodyId>();
      w.apply_impulse(id, get<Vec2>());
      break;
    }
    case Op::apply_impulse_at: {
      const auto id = get<BodyId>();
      const auto impulse = get<Vec2>();
      w.apply_impulse_at(id, impulse, get<Vec2>());
      break;
    }
    case Op::apply_angular_impulse: {
      const auto id = get<BodyId>();
      w.apply_angular_impulse(id, get<double>());
      break;
    }
    case Op::set_gravity: w.set_gravity(get<Vec2>()); break;
    case Op::set_skin: w.set_skin(get<double>()); break;
    case Op::set_sleeping: w.set_sleeping(get<bool>()); break;
    case Op::wake: w.wake(get<BodyId>()); break;
    case Op::add_joint: w.add_joint(get<JointDesc>(), error); break;
    case Op::remove_joint: w.remove_joint(get<JointId>()); break;
    case Op::set_motor: {
      const auto id = get<JointId>();
      const auto speed = get<double>();
      w.set_motor(id, speed, get<double>());
      break;
    }
    default: log->fail("it is damaged");
  }
  return true;
}

Replay::Replay(std::unique_ptr<State> state) : state_(std::move(state)) {}
Replay::~Replay() = default;

std::unique_ptr<Replay> Replay::open(std::span<const std::byte> recording, const RunOptions& options,
                                     std::string& error) {
  error.clear();
  RecordHeader header;
  if (recording.size() < sizeof header) {
    error = "it is cut short";
    return nullptr;
  }
  std::memcpy(&header, recording.data(), sizeof header);
  const auto rest = recording.subspan(sizeof header);
  if (header.magic != RecordHeader::kMagic) {
    error = "it is no recording of psim";
  } else if (header.format != RecordHeader::kFormat) {
    error = "its format is " + std::to_string(header.format) + ", this psim reads " +
            std::to_string(RecordHeader::kFormat);
  } else if (recording.size() < header.size) {
    error = "it is cut short";
  } else if (recording.size() > header.size || header.hash_with(rest) != header.hash ||
             header.state > rest.size()) {
    error = "it is damaged";
  }
  if (!error.empty()) return nullptr;
  auto state = std::make_unique<State>();
  state->world = World::from_state(rest.first(header.state), options, error);
  if (!state->world) return nullptr;
  const auto log = rest.subspan(header.state);
  state->bytes.assign(log.begin(), log.end());
  state->log.emplace(Loader::of_numbers(state->bytes));
  state->in_all = header.steps;
  return std::unique_ptr<Replay>(new Replay(std::move(state)));
}

bool Replay::next() {
  State& s = *state_;
  const std::uint64_t before = s.steps;
  while (!s.log->at_end() && s.log->ok()) {
    Op op{};
    s.log->value(op);
    if (s.perform(op)) continue;
    // Hashes after a step belong to it.
    while (s.log->ok() && !s.log->at_end() && s.log->peek() == static_cast<std::byte>(Op::hash)) {
      s.log->value(op);
      s.check();
    }
    break;
  }
  return s.steps != before;
}

bool Replay::complete() const {
  const State& s = *state_;
  return s.log->ok() && s.log->at_end() && s.compared && s.steps == s.in_all;
}

World& Replay::world() { return *state_->world; }
std::uint64_t Replay::steps() const { return state_->steps; }
std::uint64_t Replay::steps_in_all() const { return state_->in_all; }
std::uint64_t Replay::hashes() const { return state_->hashes; }
std::uint64_t Replay::differs_at() const { return state_->differs; }

}  // namespace psim
