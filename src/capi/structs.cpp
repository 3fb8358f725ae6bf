#include "structs.h"

#include <algorithm>

#include "convert.h"
#include "psim/mover.h"

namespace psim::capi {
namespace {

template <class T>
T zeros() {
  T d;
  std::memset(&d, 0, sizeof d);
  d.struct_size = sizeof d;
  return d;
}

// The defaults of a struct, as many of them as fit into `size` bytes.
template <class T>
void fill(void* object, std::uint32_t size) {
  T d = zeros<T>();
  if constexpr (requires { set_defaults(d); }) set_defaults(d);
  std::memcpy(object, &d, std::min<std::size_t>(size, sizeof d));
}

}  // namespace

void set_defaults(psim_world_desc& d) {
  const WorldDesc from;
  d = zeros<psim_world_desc>();
  d.boundary = static_cast<std::int32_t>(from.boundary);
  d.bounds = to_c(from.bounds);
  d.gravity = to_c(from.gravity);
  d.linear_damping = from.linear_damping;
  d.wall = to_c(from.wall);
  d.dt = from.dt;
  d.substeps = from.substeps;
  d.integrator = static_cast<std::int32_t>(from.integrator);
  d.restitution_threshold = from.restitution_threshold;
  d.sleeping = from.sleeping;
  d.skin = from.skin;
  d.restitution_mixing = static_cast<std::int32_t>(from.mixing.restitution);
  d.friction_mixing = static_cast<std::int32_t>(from.mixing.friction);
}

void set_defaults(psim_run_options& d) {
  d = zeros<psim_run_options>();
  d.isa = PSIM_ISA_BEST;
  d.threads = 1;
}

void set_defaults(psim_body_desc& d) {
  const BodyDesc from;
  d = zeros<psim_body_desc>();
  d.type = static_cast<std::int32_t>(from.type);
  d.shape = psim_disc(DiscShape{}.radius);
  d.material = to_c(from.material);
  d.gravity_scale = from.gravity_scale;
  d.filter = to_c(from.filter);
}

void set_defaults(psim_body_traits& d) { d = zeros<psim_body_traits>(); }

void set_defaults(psim_part_traits& d) { d = zeros<psim_part_traits>(); }

void set_defaults(psim_disc_batch& d) {
  const DiscBatch from;
  d = zeros<psim_disc_batch>();
  d.type = static_cast<std::int32_t>(from.type);
  d.common_radius = DiscShape{}.radius;
  d.material = to_c(from.material);
  d.gravity_scale = from.gravity_scale;
  d.filter = to_c(from.filter);
}

void set_defaults(psim_joint_desc& d) {
  const JointDesc from;
  d = zeros<psim_joint_desc>();
  d.type = static_cast<std::int32_t>(from.type);
  d.a = to_c(from.a);
  d.b = to_c(from.b);
  d.axis = to_c(from.axis);
  d.ratio = from.ratio;
  d.joint_a = to_c(from.joint_a);
  d.joint_b = to_c(from.joint_b);
}

void set_defaults(psim_query_filter& d) {
  const QueryFilter from;
  d = zeros<psim_query_filter>();
  d.mask = from.mask;
  d.dynamic = from.dynamic;
  d.kinematic = from.kinematic;
  d.fixed = from.fixed;
  d.sensors = from.sensors;
  d.category = from.category;
  d.ignore = to_c(from.ignore);
}

void set_defaults(psim_debug_draw& d) {
  const DebugDrawOptions from;
  d = zeros<psim_debug_draw>();
  d.bodies = from.bodies;
  d.joints = from.joints;
  d.contacts = from.contacts;
  d.forces = from.forces;
  d.bounds = from.bounds;
  d.particles = from.particles;
  d.force_scale = from.force_scale;
  d.normal_length = from.normal_length;
}

void set_defaults(psim_mover_desc& d) {
  const MoverDesc from;
  d = zeros<psim_mover_desc>();
  d.radius = from.radius;
  d.half_height = from.half_height;
  d.up = to_c(from.up);
  d.slope_limit = from.slope_limit;
  d.step_height = from.step_height;
  d.skin = from.skin;
  d.push_force = from.push_force;
}

void set_defaults(psim_fluid_desc& d) {
  const FluidDesc from;
  d = zeros<psim_fluid_desc>();
  d.density = from.density;
  d.viscosity = from.viscosity;
  d.surface_tension = from.surface_tension;
}

void set_defaults(psim_emitter_desc& d) {
  const EmitterDesc from;
  d = zeros<psim_emitter_desc>();
  d.end = from.end;
  d.limit = from.limit;
}

void set_defaults(psim_event_options& d) {
  d = zeros<psim_event_options>();
  d.hit_speed = EventOptions{}.hit_speed;
}

void set_defaults(psim_cost_model& d) { d = to_c(CostModel{}); }

void set_defaults(psim_governor_desc& d) {
  d = zeros<psim_governor_desc>();
  d.budget_ms = GovernorDesc{}.budget_ms;
}

void set_defaults(psim_job_system& d) {
  d = zeros<psim_job_system>();
  d.workers = 1;
}

psim_result read_options(const Call& call, const psim_run_options* options, RunOptions& out) {
  if (options == nullptr) return PSIM_OK;
  psim_run_options given;
  if (const psim_result r = read(call, "options", options, given); r != PSIM_OK) return r;
  const std::string wrong = convert(given, out);
  if (!wrong.empty()) return call.fail(PSIM_ERROR_ARGUMENT, wrong);
  if (isa_available(out.isa)) return PSIM_OK;
  return call.fail(PSIM_ERROR_UNSUPPORTED, "this CPU has no " + std::string(isa_name(out.isa)));
}

void keep_fields(psim_world& handle) {
  handle.fields.clear();
  handle.media.clear();
  for (const Field& field : handle.world->desc().fields) {
    if (is_medium(field)) {
      handle.media.push_back(to_medium(field));
    } else {
      handle.fields.push_back(to_c(field));
    }
  }
}

std::string wrong_size(const char* what, std::uint32_t size, std::size_t known) {
  if (size >= 8 && size % 8 == 0 && size <= known) return {};
  const std::string has = std::string(what) + " has struct_size " + std::to_string(size);
  if (size > known && size % 8 == 0) {
    return has + ", this library knows " + std::to_string(known) + ": it is older than the header";
  }
  return has + "; call its init function first";
}

}  // namespace psim::capi

using namespace psim::capi;

void psim_init(void* object, int32_t kind, uint32_t size) {
  if (object == nullptr || size < 8 || kind < PSIM_STRUCT_WORLD_DESC || kind > PSIM_STRUCT_EMITTER_DESC) {
    return;
  }
  std::memset(object, 0, size);
  switch (kind) {
    case PSIM_STRUCT_WORLD_DESC:
      fill<psim_world_desc>(object, size);
      break;
    case PSIM_STRUCT_RUN_OPTIONS:
      fill<psim_run_options>(object, size);
      break;
    case PSIM_STRUCT_BODY_DESC:
      fill<psim_body_desc>(object, size);
      break;
    case PSIM_STRUCT_DISC_BATCH:
      fill<psim_disc_batch>(object, size);
      break;
    case PSIM_STRUCT_JOINT_DESC:
      fill<psim_joint_desc>(object, size);
      break;
    case PSIM_STRUCT_QUERY_FILTER:
      fill<psim_query_filter>(object, size);
      break;
    case PSIM_STRUCT_PART_TRAITS:
      fill<psim_part_traits>(object, size);
      break;
    case PSIM_STRUCT_FLUID_DESC:
      fill<psim_fluid_desc>(object, size);
      break;
    case PSIM_STRUCT_EMITTER_DESC:
      fill<psim_emitter_desc>(object, size);
      break;
    case PSIM_STRUCT_DEBUG_DRAW:
      fill<psim_debug_draw>(object, size);
      break;
    case PSIM_STRUCT_MOVER_DESC:
      fill<psim_mover_desc>(object, size);
      break;
    case PSIM_STRUCT_EVENT_OPTIONS:
      fill<psim_event_options>(object, size);
      break;
    case PSIM_STRUCT_COST_MODEL:
      fill<psim_cost_model>(object, size);
      break;
    case PSIM_STRUCT_GOVERNOR_DESC:
      fill<psim_governor_desc>(object, size);
      break;
    case PSIM_STRUCT_JOB_SYSTEM:
      fill<psim_job_system>(object, size);
      break;
    default:  // what is written by us begins as zeros
      break;
  }
  std::memcpy(object, &size, sizeof size);  // struct_size comes first in all of them
}
