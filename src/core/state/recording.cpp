#include "psim/recording.h"

#include "base/room.h"
#include "bodies/body_desc.h"
#include "state/recording_log.h"

namespace psim {
using namespace recorded;

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
    std::size_t bytes = kStepAndHash + kEnd + kAnswersBytes;
    for (const Answers& each : answers) bytes += kAnswersBytes + each.size() * kAnswerBytes;
    saver.room_for(bytes);
  }

  template <class... T>
  void write(std::uint8_t op, T&... args) {
    values(saver, op, args...);
  }
  template <class... T>
  void add(std::uint8_t op, T... args) {
    write(op, args...);
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
      if (!ended) end(world, before);
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

FluidId Recorder::add_fluid(const FluidDesc& desc, std::string& error) {
  const auto add = [&] { return world_.add_fluid(desc, error) + 1; };  // 0: it is refused
  return log_->done(
             world_, [&] { log_->add(kAddFluid, desc); }, add) -
         1;
}

bool Recorder::add_particles(FluidId fluid, std::span<const Vec2> positions, std::span<const Vec2> velocities,
                             std::string& error) {
  const auto write = [&] {
    const auto copy = [](std::span<const Vec2> from) { return std::vector<Vec2>(from.begin(), from.end()); };
    log_->add(kAddParticles, fluid, copy(positions), copy(velocities));
  };
  return log_->done(world_, write, [&] { return world_.add_particles(fluid, positions, velocities, error); });
}

EmitterId Recorder::add_emitter(const EmitterDesc& desc, std::string& error) {
  const auto add = [&] { return world_.add_emitter(desc, error) + 1; };  // 0: it is refused
  return log_->done(
             world_, [&] { log_->add(kAddEmitter, desc); }, add) -
         1;
}

DrainId Recorder::add_drain(const Bounds& region, std::string& error) {
  const auto add = [&] { return world_.add_drain(region, error) + 1; };  // 0: it is refused
  return log_->done(
             world_, [&] { log_->add(kAddDrain, region); }, add) -
         1;
}

bool Recorder::remove_emitter(EmitterId id) { return log_->call<21>(world_, id); }
bool Recorder::set_emitter_speed(EmitterId id, double speed) { return log_->call<22>(world_, id, speed); }
bool Recorder::remove_drain(DrainId id) { return log_->call<23>(world_, id); }
bool Recorder::remove_body(BodyId id) { return log_->call<0>(world_, id); }
std::size_t Recorder::remove_bodies(std::span<const BodyId> ids) {
  Log& log = *log_;
  std::vector<BodyId> given;
  const std::size_t before = log.saver.bytes().size();
  const auto write = [&] {
    given.assign(ids.begin(), ids.end());
    log.write(kRemoveBodies, given);
  };
  const auto remove = [&] {
    const std::size_t removed = world_.remove_bodies(ids);
    if (!ran_out_of_memory() || removed == 0 || log.ended) return removed;
    // Some are gone and others stay: that is written down, and the recording ends behind it.
    std::erase_if(given, [this](BodyId id) { return world_.is_valid(id); });
    log.saver.cut(before);
    log.write(kRemoveBodies, given);
    log.end(world_, log.saver.bytes().size());
    return removed;
  };
  return log.done(world_, write, remove);
}
std::size_t Recorder::add_bodies(std::span<const BodyDesc> descs, std::span<BodyId> ids, std::string& error) {
  return add_in_order(*this, descs, ids, error);
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
std::size_t Recorder::set_transforms(std::span<const BodyId> ids, std::span<const Vec2> positions,
                                     std::span<const double> angles) {
  return count_done([this](const auto&... of) { return set_transform(of...); }, ids, positions, angles);
}
std::size_t Recorder::set_velocities(std::span<const BodyId> ids, std::span<const Vec2> velocities,
                                     std::span<const double> angular_velocities) {
  return count_done([this](const auto&... of) { return set_velocity(of...); }, ids, velocities, angular_velocities);
}
std::size_t Recorder::apply_impulses(std::span<const BodyId> ids, std::span<const Vec2> impulses) {
  return count_done([this](const auto&... of) { return apply_impulse(of...); }, ids, impulses);
}
std::size_t Recorder::apply_forces(std::span<const BodyId> ids, std::span<const Vec2> forces) {
  return count_done([this](const auto&... of) { return apply_force(of...); }, ids, forces);
}
std::size_t Recorder::set_traits_of(std::span<const BodyId> ids, std::span<const BodyTraits> traits) {
  return count_done([this](const auto&... of) { return set_traits(of...); }, ids, traits);
}
std::size_t Recorder::set_enabled_of(std::span<const BodyId> ids, bool on) {
  return count_done([&](BodyId id) { return set_enabled(id, on); }, ids);
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

}  // namespace psim
