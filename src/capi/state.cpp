// What is read out of a world.
#include "convert.h"
#include "structs.h"

using namespace psim::capi;

psim_result psim_world_state(psim_world* world, psim_state* state) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_output(call, "state", state); r != PSIM_OK) return r;
    const psim::PublishedState from = w.published();
    psim_state out;
    psim_state_init(&out);
    out.count = from.id.size();
    out.id = from.id.data();
    out.x = from.x.data();
    out.y = from.y.data();
    out.angle = from.angle.data();
    out.vx = from.vx.data();
    out.vy = from.vy.data();
    out.omega = from.omega.data();
    out.radius = from.radius.data();
    static_assert(sizeof(psim::BodyType) == 1);
    out.type = reinterpret_cast<const std::uint8_t*>(from.type.data());
    write(out, state);
    return PSIM_OK;
  });
}

psim_result psim_world_enable_snapshots(psim_world* world, int32_t on) {
  return guarded(world, __func__, [on](psim::World& w, const Call&) -> psim_result {
    w.enable_snapshots(on != 0);
    return PSIM_OK;
  });
}

psim_result psim_world_latest_snapshot(psim_world* world, psim_snapshot* snapshot) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_output(call, "snapshot", snapshot); r != PSIM_OK) return r;
    const psim::Snapshot* from = w.latest_snapshot();
    if (from == nullptr) return PSIM_NOTHING;
    psim_snapshot out;
    psim_snapshot_init(&out);
    out.frame = from->frame;
    out.count = from->id.size();
    out.id = from->id.data();
    out.x = from->x.data();
    out.y = from->y.data();
    out.x_prev = from->x_prev.data();
    out.y_prev = from->y_prev.data();
    out.angle = from->angle.data();
    out.angle_prev = from->angle_prev.data();
    out.radius = from->radius.data();
    out.speed = from->speed.data();
    out.asleep = from->asleep.data();
    out.origin = to_c(from->origin);
    write(out, snapshot);
    return PSIM_OK;
  });
}

uint64_t psim_world_state_hash(const psim_world* world) {
  return asked(world, __func__, uint64_t{0}, [](const psim::World& w) { return w.state_hash(); });
}

psim_result psim_world_diagnostics(psim_world* world, psim_diagnostics* diagnostics) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    const psim_result r = check_output(call, "diagnostics", diagnostics);
    if (r != PSIM_OK) return r;
    const psim::Diagnostics d = w.diagnostics();
    write(psim_diagnostics{sizeof(psim_diagnostics), 0, d.kinetic, d.potential, d.momentum_x, d.momentum_y,
                           d.angular_momentum, d.max_penetration},
          diagnostics);
    return PSIM_OK;
  });
}

psim_result psim_world_lane_counts(const psim_world* world, psim_lane_counts* counts) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (counts == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "counts must not be NULL");
    const psim::LaneCounts lanes = w.lane_counts();
    *counts = {lanes.vector, lanes.scalar};
    return PSIM_OK;
  });
}

size_t psim_world_memory_bytes(const psim_world* world) {
  return asked(world, __func__, size_t{0}, [](const psim::World& w) { return w.memory_bytes(); });
}

namespace {

// Gives out a list of the handle.
template <class Item>
psim_result give(const std::vector<Item>& list, const Item** items, size_t* count) {
  *items = list.data();
  *count = list.size();
  return PSIM_OK;
}

template <class Item>
psim_result check_list(const Call& call, const Item** items, const size_t* count) {
  if (items != nullptr && count != nullptr) return PSIM_OK;
  return call.fail(PSIM_ERROR_ARGUMENT, "the list and its count must not be NULL");
}

}  // namespace

psim_result psim_world_plan(psim_world* world, const psim_plan_entry** entries, size_t* count) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_list(call, entries, count); r != PSIM_OK) return r;
    world->plan_text = w.plan();
    world->plan.clear();
    for (const psim::PlanEntry& e : world->plan_text) {
      world->plan.push_back({e.stage.c_str(), e.reason.c_str(), e.needed, 0});
    }
    return give(world->plan, entries, count);
  });
}

psim_result psim_world_plan_bytes(psim_world* world, const size_t** bytes, size_t* count) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_list(call, bytes, count); r != PSIM_OK) return r;
    world->plan_bytes.clear();
    for (const psim::PlanEntry& e : w.plan()) world->plan_bytes.push_back(e.bytes);
    return give(world->plan_bytes, bytes, count);
  });
}

psim_result psim_world_count_lane_use(psim_world* world) {
  return guarded(world, __func__, [](psim::World& w, const Call&) -> psim_result {
    w.count_lane_use();
    return PSIM_OK;
  });
}

psim_result psim_world_lane_use(psim_world* world, const psim_lane_use** uses, size_t* count) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_list(call, uses, count); r != PSIM_OK) return r;
    world->lane_names = w.lane_use();
    world->lane_use.clear();
    for (const psim::LaneUse& u : world->lane_names) {
      world->lane_use.push_back({u.kernels.c_str(), u.lanes, u.used});
    }
    return give(world->lane_use, uses, count);
  });
}

psim_result psim_world_skipped(psim_world* world, const psim_skip_entry** entries, size_t* count) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_list(call, entries, count); r != PSIM_OK) return r;
    world->skipped_text = w.skipped();
    world->skipped.clear();
    for (const auto& [stage, frames] : world->skipped_text) {
      world->skipped.push_back({stage.c_str(), frames});
    }
    return give(world->skipped, entries, count);
  });
}

psim_result psim_world_start_trace(psim_world* world) {
  return guarded(world, __func__, [](psim::World& w, const Call&) -> psim_result {
    w.start_trace();
    return PSIM_OK;
  });
}

psim_result psim_world_stop_trace(psim_world* world) {
  return guarded(world, __func__, [](psim::World& w, const Call&) -> psim_result {
    w.stop_trace();
    return PSIM_OK;
  });
}

psim_result psim_world_take_trace(psim_world* world, const psim_trace_event** events, size_t* count) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_list(call, events, count); r != PSIM_OK) return r;
    world->trace.clear();
    for (const psim::TraceEvent& e : w.take_trace()) {
      world->trace.push_back({e.name, e.thread, 0, e.begin_ns, e.end_ns});
    }
    return give(world->trace, events, count);
  });
}
