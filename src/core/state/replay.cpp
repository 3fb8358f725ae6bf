// Runs recordings.
#include <optional>

#include "psim/recording.h"
#include "state/recording_log.h"

namespace psim {
using namespace recorded;

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
  // A change of the host.
  void change(std::uint8_t op) {
    World& w = *world;
    std::string error;
    switch (op) {
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
      case kRemoveBodies:
        w.remove_bodies(get<std::vector<BodyId>>());
        break;
      case kSetFields:
        w.set_fields(get<std::vector<Field>>(), error);
        break;
      case kAddFluid:
        w.add_fluid(get<FluidDesc>(), error);
        break;
      case kAddParticles: {
        const auto fluid = get<FluidId>();
        const auto positions = get<std::vector<Vec2>>();
        const auto velocities = get<std::vector<Vec2>>();
        if (log->ok()) w.add_particles(fluid, positions, velocities, error);
        break;
      }
      case kAddEmitter:
        w.add_emitter(get<EmitterDesc>(), error);
        break;
      case kAddDrain:
        w.add_drain(get<Bounds>(), error);
        break;
      default:
        call(op - std::size_t{kCallsBegin});
    }
  }
  // The next entry of the log.
  void perform() {
    World& w = *world;
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
      default:
        change(op);
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
