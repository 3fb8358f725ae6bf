#include "psim/recording.h"

#include <array>
#include <tuple>

#include "base/room.h"
#include "state/describe_calls.h"

namespace psim {
namespace {

// Calls of the host that take what they are given, each by its place in this list.
constexpr std::tuple kCalls{&World::remove_body,   &World::set_transform,    &World::set_velocity,
                            &World::apply_impulse, &World::apply_impulse_at, &World::apply_angular_impulse,
                            &World::set_gravity,   &World::set_sleeping,     &World::wake,
                            &World::remove_joint,  &World::set_motor,        &World::set_skin,
                            &World::set_enabled,   &World::set_traits,       &World::set_user_data,
                            &World::set_target,    &World::apply_force,      &World::apply_force_at,
                            &World::apply_torque,  &World::explode,          &World::set_part_traits};

// What an entry of the log is: one of these, or behind them a call.
enum Op : std::uint8_t {
  kStep,
  kHash,
  kAddBody,
  kAddDiscs,
  kAddJoint,
  kSetJoint,
  kSetFields,
  kSetBody,
  kDecide,
  kCallsBegin
};
constexpr std::uint8_t kOps = kCallsBegin + std::tuple_size_v<decltype(kCalls)>;

struct RecordHeader : FileHeader {
  static constexpr std::uint64_t kMagic = 0x31304352'6D697370u;  // "psimRC01"
  static constexpr std::uint64_t kFormat = 12;
  std::uint64_t state = 0;  ///< bytes of the state that it began with
  std::uint64_t steps = 0;

  void seal(std::span<const std::byte> rest) {
    const std::uint64_t hash = hash_of(rest) + 0x9E3779B97F4A7C15u * steps;
    static_cast<FileHeader&>(*this) = {kMagic, kFormat, sizeof *this + rest.size(), hash};
  }
};

}  // namespace

namespace recorded {

// What the host said of one new contact, and of all that it was shown at once.
struct Answer {
  bool enabled = true;
  std::array<double, 4> surface{};  // friction, restitution, tangent speed, rolling resistance
};
using Answers = std::vector<Answer>;
inline auto fields(Answer& a) { return std::tie(a.enabled, a.surface); }
constexpr std::size_t kAnswerBytes = 33, kAnswersBytes = 32;  // no less than they take in a log

}  // namespace recorded
using recorded::Answer, recorded::Answers;

namespace {

// What a DiscBatch looks at.
using Discs = std::array<std::vector<double>, 7>;

void describe(Archive& a, DiscBatch& b, Discs& discs) {
  std::span<const double>* seen[] = {&b.x, &b.y, &b.radius, &b.angle, &b.vx, &b.vy, &b.angular_velocity};
  for (std::size_t k = 0; k < discs.size(); ++k) {
    discs[k].assign(seen[k]->begin(), seen[k]->end());
    values(a, discs[k]);
    *seen[k] = discs[k];
  }
  values(a, b.type, b.material, b.mass, b.gravity_scale, b.fixed_rotation, b.bullet, b.filter);
}

}  // namespace

// ---- recorder --------------------------------------------------------------------------------------

struct Recorder::Log {
  static constexpr std::size_t kEnd = 16, kStepAndHash = 64;  // bytes: no less than these entries take

  std::vector<std::byte> state;
  Saver saver;
  bool ended = false;
  std::uint64_t every = 60, steps = 0;
  PreSolve host;                 // answers for the world
  std::vector<Answers> answers;  // in this step

  // Makes room for the answers, too, before they count.
  void note(std::span<const NewContact> contacts) {
    if (ended) return;
    Answers& some = answers.emplace_back();
    for (const NewContact& c : contacts) {
      some.push_back({c.enabled, {c.friction, c.restitution, c.tangent_speed, c.rolling_resistance}});
    }
    std::size_t bytes = kStepAndHash + kEnd + recorded::kAnswersBytes;
    for (const Answers& each : answers) bytes += recorded::kAnswersBytes + each.size() * recorded::kAnswerBytes;
    saver.room_for(bytes);
  }

  template <class... T>
  void add(std::uint8_t op, T... args) {
    values(saver, op, args...);
  }
  // A call found no memory. It changed no number, but sleepers may have woken, which is not written down: the recording
  // ends before it.
  void end(const World& world, std::size_t before) {
    saver.cut(before);
    add(kHash, world.state_hash());  // kEnd bytes
    ended = true;
    ran_out_of_memory() = true;
  }
  // Writes down what write() writes, and does it by call(). What is refused is not written down.
  template <class Write, class Call>
  auto done(const World& world, const Write& write, const Call& call) {
    if (ended) return call();
    const std::size_t before = saver.bytes().size();
    const bool told = std::exchange(ran_out_of_memory(), false);
    decltype(call()) answer{}, none{};
    try {
      write();
      saver.room_for(kEnd);
      answer = call();
    } catch (const std::bad_alloc&) {  // there is no room for the recording; the world has values
      ran_out_of_memory() = true;
    }
    if (ran_out_of_memory()) {
      end(world, before);
    } else if (answer == none) {
      saver.cut(before);
    }
    ran_out_of_memory() = told || ran_out_of_memory();
    return answer;
  }
  // Writes down a call of kCalls, and does it.
  template <std::size_t kCall, class... T>
  auto call(World& world, const T&... args) {
    const auto does = [&] {
      if constexpr (std::is_void_v<decltype((world.*std::get<kCall>(kCalls))(args...))>) {
        (world.*std::get<kCall>(kCalls))(args...);
        return true;
      } else {
        return (world.*std::get<kCall>(kCalls))(args...);
      }
    };
    return done(
        world, [&] { add(kCallsBegin + kCall, args...); }, does);
  }
  template <class Step>
  StepReport step(World& world, double dt, const Step& step) {
    if (ended) return step();
    const std::uint64_t frame = world.frame();
    const std::size_t before = saver.bytes().size();
    StepReport report;
    try {
      answers.clear();
      saver.room_for(kStepAndHash + kEnd);
      report = step();
    } catch (const std::bad_alloc&) {
      report.no_room_for = "recording";
      report.detail.solves = false;
    }
    if (world.frame() == frame) {  // refused
      if (report.no_room_for != nullptr) end(world, before);
    } else {
      if (!answers.empty()) add(kDecide, answers);
      add(kStep, dt, report.detail);
      if (++steps % every == 0) add(kHash, world.state_hash());
    }
    return report;
  }
};

Recorder::Recorder(World& world, std::uint64_t every) : world_(world), log_(std::make_unique<Log>()) {
  log_->every = std::max<std::uint64_t>(every, 1);
  log_->saver.room_for(Log::kEnd);
  world.save(log_->state);
  set_pre_solve(world.pre_solve());
}
Recorder::~Recorder() { world_.set_pre_solve(std::move(log_->host)); }

void Recorder::set_pre_solve(PreSolve pre_solve) {
  log_->host = std::move(pre_solve);
  if (!log_->host) return world_.set_pre_solve({});
  world_.set_pre_solve([log = log_.get()](std::span<NewContact> contacts) {
    log->host(contacts);
    log->note(contacts);
  });
}

StepReport Recorder::step() { return step(world_.desc().dt); }

StepReport Recorder::step(double dt) {
  return log_->step(world_, dt, [&] { return world_.step(dt); });
}

StepReport Recorder::replay(const StepDetail& detail) { return replay(detail, world_.desc().dt); }

StepReport Recorder::replay(const StepDetail& detail, double dt) {
  return log_->step(world_, dt, [&] { return world_.replay(detail, dt); });
}

BodyId Recorder::add_body(const BodyDesc& desc, std::string& error) {
  return log_->done(
      world_, [&] { log_->add(kAddBody, desc); }, [&] { return world_.add_body(desc, error); });
}

std::size_t Recorder::add_discs(const DiscBatch& batch, std::uint32_t& first, std::string& error) {
  const auto write = [&] {
    DiscBatch copy = batch;
    Discs discs;
    log_->add(kAddDiscs);
    describe(log_->saver, copy, discs);
  };
  return log_->done(world_, write, [&] { return world_.add_discs(batch, first, error); });
}

JointId Recorder::add_joint(const JointDesc& desc, std::string& error) {
  return log_->done(
      world_, [&] { log_->add(kAddJoint, desc); }, [&] { return world_.add_joint(desc, error); });
}

bool Recorder::set_joint(JointId id, const JointDesc& desc, std::string& error) {
  return log_->done(
      world_, [&] { log_->add(kSetJoint, id, desc); }, [&] { return world_.set_joint(id, desc, error); });
}

bool Recorder::set_body(BodyId id, const BodyDesc& desc, std::string& error) {
  return log_->done(
      world_, [&] { log_->add(kSetBody, id, desc); }, [&] { return world_.set_body(id, desc, error); });
}

bool Recorder::set_fields(const std::vector<Field>& given, std::string& error) {
  return log_->done(
      world_, [&] { log_->add(kSetFields, given); }, [&] { return world_.set_fields(given, error); });
}

bool Recorder::remove_body(BodyId id) { return log_->call<0>(world_, id); }
std::size_t Recorder::remove_bodies(std::span<const BodyId> ids) {
  std::size_t removed = 0;
  for (const BodyId id : ids) removed += remove_body(id) ? 1 : 0;
  return removed;
}
bool Recorder::set_transform(BodyId id, Vec2 position, double angle) {
  return log_->call<1>(world_, id, position, angle);
}
bool Recorder::set_velocity(BodyId id, Vec2 velocity, double angular_velocity) {
  return log_->call<2>(world_, id, velocity, angular_velocity);
}
bool Recorder::apply_impulse(BodyId id, Vec2 impulse) { return log_->call<3>(world_, id, impulse); }
bool Recorder::apply_impulse_at(BodyId id, Vec2 impulse, Vec2 point) {
  return log_->call<4>(world_, id, impulse, point);
}
bool Recorder::apply_angular_impulse(BodyId id, double impulse) { return log_->call<5>(world_, id, impulse); }
bool Recorder::apply_force(BodyId id, Vec2 force) { return log_->call<16>(world_, id, force); }
bool Recorder::apply_force_at(BodyId id, Vec2 force, Vec2 point) { return log_->call<17>(world_, id, force, point); }
bool Recorder::apply_torque(BodyId id, double torque) { return log_->call<18>(world_, id, torque); }
std::optional<std::size_t> Recorder::explode(const Explosion& explosion) { return log_->call<19>(world_, explosion); }
bool Recorder::set_gravity(Vec2 gravity) { return log_->call<6>(world_, gravity); }
void Recorder::set_sleeping(bool on) { log_->call<7>(world_, on); }
bool Recorder::wake(BodyId id) { return log_->call<8>(world_, id); }
bool Recorder::remove_joint(JointId id) { return log_->call<9>(world_, id); }
bool Recorder::set_motor(JointId id, double speed, double limit) { return log_->call<10>(world_, id, speed, limit); }
bool Recorder::set_target(JointId id, Vec2 point) { return log_->call<15>(world_, id, point); }
bool Recorder::set_skin(double factor) { return log_->call<11>(world_, factor); }
bool Recorder::set_enabled(BodyId id, bool on) { return log_->call<12>(world_, id, on); }
bool Recorder::set_traits(BodyId id, const BodyTraits& to) { return log_->call<13>(world_, id, to); }
bool Recorder::set_part_traits(BodyId id, std::uint32_t part, const PartTraits& to) {
  return log_->call<20>(world_, id, part, to);
}
bool Recorder::set_user_data(BodyId id, std::uint64_t value) { return log_->call<14>(world_, id, value); }

std::vector<std::byte> Recorder::recording() const {
  Log end;
  if (!log_->ended) end.add(kHash, world_.state_hash());
  RecordHeader header;
  header.state = log_->state.size();
  header.steps = log_->steps;
  return sealed(header, {log_->state, log_->saver.bytes(), end.saver.bytes()});
}

// ---- replay ----------------------------------------------------------------------------------------

struct Replay::State {
  std::vector<std::byte> bytes;  // of the log
  std::unique_ptr<World> world;
  std::optional<Loader> log;
  std::uint64_t steps = 0, in_all = 0, hashes = 0, differs = 0;
  bool compared = false;         // the present state
  std::vector<Answers> answers;  // in the next step

  template <class T>
  T get() {
    T v{};
    values(*log, v);
    return v;
  }
  template <class R, class... T>
  void call(R (World::*function)(T...)) {
    std::tuple<std::decay_t<T>...> args;
    std::apply([&](auto&... arg) { values(*log, arg...); }, args);
    if (log->ok()) std::apply([&](auto&... arg) { (*world.*function)(arg...); }, args);
  }
  void call(std::size_t which) {
    std::apply(
        [&](auto... function) {
          std::size_t k = 0;
          ((k++ == which ? call(function) : void()), ...);
        },
        kCalls);
  }
  static void answer(const Answers& with, std::span<NewContact> contacts) {
    for (std::size_t k = 0; k < std::min(with.size(), contacts.size()); ++k) {
      const Answer& a = with[k];
      NewContact& c = contacts[k];
      c.enabled = a.enabled;
      c.friction = a.surface[0], c.restitution = a.surface[1];
      c.tangent_speed = a.surface[2], c.rolling_resistance = a.surface[3];
    }
  }
  // The next entry of the log.
  void perform() {
    World& w = *world;
    std::string error;
    std::uint8_t op = 0;
    log->index(kOps, op);
    compared = false;
    switch (op) {
      case kStep: {
        const auto dt = get<double>();
        const auto detail = get<StepDetail>();
        if (!log->ok()) return;
        w.replay(detail, dt);
        w.set_pre_solve({});
        ++steps;
        break;
      }
      case kDecide:
        answers = get<std::vector<Answers>>();
        w.set_pre_solve([this, next = std::size_t{0}](std::span<NewContact> contacts) mutable {
          if (next < answers.size()) answer(answers[next++], contacts);
        });
        break;
      case kHash: {
        const auto hash = get<std::uint64_t>();
        compared = log->ok();
        if (!compared) return;
        ++hashes;
        if (differs == 0 && hash != w.state_hash()) differs = std::max<std::uint64_t>(steps, 1);
        break;
      }
      case kAddBody:
        w.add_body(get<BodyDesc>(), error);
        break;
      case kAddDiscs: {
        DiscBatch batch;
        Discs discs;
        describe(*log, batch, discs);
        std::uint32_t first = 0;
        w.add_discs(batch, first, error);
        break;
      }
      case kAddJoint:
        w.add_joint(get<JointDesc>(), error);
        break;
      case kSetJoint: {
        const auto id = get<JointId>();
        w.set_joint(id, get<JointDesc>(), error);
        break;
      }
      case kSetBody: {
        const auto id = get<BodyId>();
        w.set_body(id, get<BodyDesc>(), error);
        break;
      }
      case kSetFields:
        w.set_fields(get<std::vector<Field>>(), error);
        break;
      default:
        call(op - std::size_t{kCallsBegin});
    }
  }
};

Replay::Replay(std::unique_ptr<State> state) : state_(std::move(state)) {}
Replay::~Replay() = default;

std::unique_ptr<Replay> Replay::open(std::span<const std::byte> recording, const RunOptions& options,
                                     std::string& error) {
  RecordHeader header;
  error = read_header(recording, "recording", header);
  const auto rest = recording.subspan(std::min(sizeof header, recording.size()));
  if (error.empty() && header.state > rest.size()) error = "it is damaged";
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
  // Hashes after a step belong to it.
  while (s.log->left() != 0 && (s.steps == before || s.log->peek() == std::byte{kHash})) s.perform();
  return s.steps != before;
}

bool Replay::complete() const {
  const State& s = *state_;
  return s.log->ok() && s.log->left() == 0 && s.compared && s.steps == s.in_all;
}

World& Replay::world() { return *state_->world; }
std::uint64_t Replay::steps() const { return state_->steps; }
std::uint64_t Replay::steps_in_all() const { return state_->in_all; }
std::uint64_t Replay::hashes() const { return state_->hashes; }
std::uint64_t Replay::differs_at() const { return state_->differs; }

}  // namespace psim
