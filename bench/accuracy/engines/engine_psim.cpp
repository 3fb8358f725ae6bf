// psim itself.
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "engines/engine.h"
#include "psim/psim.h"

namespace psim::accuracy {
namespace {

constexpr int kDefaultSubsteps = 4;
constexpr std::string_view kDefaultIntegrator = "verlet";

class PsimSimulation : public Simulation {
 public:
  PsimSimulation(const Model& model, const Setting& setting)
      : steps_(setting.steps), step_(setting.frame / setting.steps) {
    Scene scene = model.scene;
    scene.world.dt = step_;
    scene.world.substeps = setting.substeps;
    scene.world.integrator = parse_integrator(setting.integrator).value_or(Integrator::verlet);
    std::string error;
    world_ = build_world(scene, {setting.isa, setting.threads}, error);
    if (!world_) throw std::runtime_error(error);
    world_->set_sleeping(setting.sleeping);
    passes_ = passes_a_step(model, setting.substeps);
    points_ = has_boxes(model) ? 2 : 1;
    joint_visits_ = joint_rows(model) * (1.0 + 2.5 * kJointSweeps * setting.substeps) * steps_;
  }

  void advance() override {
    rows_ = 0;
    for (int k = 0; k < steps_; ++k) {
      const StepReport report = world_->step();
      rows_ += report.pairs;
      virial_ += report.virial;
    }
  }

  void read(std::vector<BodyState>& bodies) override {
    const PublishedState s = world_->published();
    bodies.clear();
    for (std::size_t k = 0; k < s.id.size(); ++k) {
      bodies.push_back(
          {{s.id[k], 0}, s.x[k], s.y[k], s.angle[k], s.vx[k], s.vy[k], s.omega[k], s.radius[k], s.type[k]});
    }
  }

  void set_velocity(std::size_t body, Vec2 velocity, double omega) override {
    world_->set_velocity(world_->id_of(static_cast<std::uint32_t>(body)), velocity, omega);
  }

  double row_visits() const override { return points_ * passes_ * static_cast<double>(rows_) + joint_visits_; }
  double virial() const override { return virial_; }

  std::vector<Load> loads() override {
    std::vector<Load> loads;
    for (const Contact& c : world_->contacts()) {
      if (c.b == kNoBody) continue;
      const bool again = !loads.empty() && loads.back().a == c.a.index && loads.back().b == c.b.index;
      if (!again) loads.push_back({c.a.index, c.b.index, 0});
      loads.back().force += c.impulse / step_;
    }
    return loads;
  }

 private:
  // One warm start, then solve and relax a substep; with restitution also spend and, as a rule,
  // three sweeps for impacts. Passes touch all pairs of the lists, not only those in contact.
  static double passes_a_step(const Model& model, int substeps) {
    bool bounces = model.scene.world.wall.restitution > 0;
    for (const BodyDesc& body : model.bodies) bounces |= body.material.restitution > 0;
    return 1 + (bounces ? 6 : 2) * substeps;
  }

  std::unique_ptr<World> world_;
  int steps_;
  double step_;  // s
  // Joints are swept so often in solve and in relax, half as often in between, in small scenes.
  static constexpr int kJointSweeps = 8;

  double passes_ = 0;
  double points_ = 1;  // a pair, the corners of two boxes
  double joint_visits_ = 0;
  std::uint64_t rows_ = 0;
  double virial_ = 0;
};

Setting substepped(std::string_view integrator, int substeps) {
  Setting s;
  s.integrator = integrator;
  s.curve = integrator;
  s.substeps = substeps;
  s.is_default = substeps == kDefaultSubsteps && integrator == kDefaultIntegrator;
  return s;
}

std::vector<int> substep_sweep(Effort effort, Scale scale) {
  if (effort == Effort::quick) return {1, 4, 8};
  if (scale == Scale::large) return {1, 2, 4, 8, 16, 32};
  return {1, 2, 4, 8, 16, 32, 64};
}

/// The same h by shorter frames with the default's substeps.
void append_short_frames(Scale scale, std::vector<Setting>& settings) {
  for (const int steps : {2, 4, 8, 16}) {
    if (scale == Scale::large && steps > 4) break;
    Setting s = substepped(kDefaultIntegrator, kDefaultSubsteps);
    s.curve += " short-frames";
    s.steps = steps;
    s.is_default = false;
    settings.push_back(s);
  }
}

/// What changes the time and no bit of the result.
void append_machine_variants(Scale scale, std::vector<Setting>& settings) {
  const Setting base = substepped(kDefaultIntegrator, kDefaultSubsteps);
  for (const Isa isa : kAllIsas) {
    if (isa == base.isa || !isa_available(isa)) continue;
    Setting s = base;
    s.isa = isa;
    s.curve.append(" ").append(isa_name(isa));
    s.is_default = false;
    settings.push_back(s);
  }
  for (int threads = 2; scale == Scale::large && threads <= usable_threads(); threads *= 2) {
    Setting s = base;
    s.threads = threads;
    s.curve.append(" threads-").append(std::to_string(threads));
    s.is_default = false;
    settings.push_back(s);
  }
}

std::vector<Setting> psim_settings(Effort effort, Scale scale) {
  std::vector<Setting> settings;
  for (const Integrator integrator : kAllIntegrators) {
    for (const int k : substep_sweep(effort, scale)) {
      settings.push_back(substepped(integrator_name(integrator), k));
    }
  }
  if (effort == Effort::full) append_short_frames(scale, settings);
  append_machine_variants(scale, settings);
  return settings;
}

}  // namespace

Engine psim_engine() {
  Engine engine;
  engine.name = "psim";
  engine.version = PSIM_VERSION_STRING;
  engine.refuses = [](const Model&) { return std::string(); };
  engine.make = [](const Model& model, const Setting& setting) {
    return std::make_unique<PsimSimulation>(model, setting);
  };
  engine.settings = psim_settings;
  return engine;
}

}  // namespace psim::accuracy
