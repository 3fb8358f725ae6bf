#include "fluid/fluid_bodies.h"

#include <algorithm>
#include <cmath>

#include "fluid/fluid_cut.h"

namespace psim {

using kernels::kTile;
using S = FluidSolver;

namespace {

constexpr float kApartFromShapes = 0.125f;  // cells: particles keep so far from shapes
constexpr float kMostWayOut = 1.5f;         // cells: a particle within a shape goes out by so much in a step
constexpr int kMostStops = 3;               // in a corner of several shapes
constexpr double kSlow = 0.03;              // m/s: bodies that are not faster may fall asleep
constexpr double kStirring = 0.1;           // weight of the last step in what stirs a body that sleeps

bool by_body(const FluidSolid& a, const FluidSolid& b) {
  return a.body != b.body ? a.body < b.body : a.order < b.order;
}

}  // namespace

void TileSolids::find(const SolidFinder& finder, std::span<const std::uint64_t> keys, const FluidSpace& space,
                      float reach, WorkerPool& pool) {
  constexpr std::size_t kTilesAJob = 4;
  by_tile_.resize(keys.size());
  const auto look = [&](std::size_t t, std::vector<SolidFinder::Found>& found) {
    found.clear();
    by_tile_[t].clear();
    const double wide = kTile * space.cell_x, high = kTile * space.cell_y;
    const Vec2 corner{space.left + wide * column_of(keys[t]), space.bottom + high * row_of(keys[t])};
    const Vec2 far{double{reach}, double{reach}};
    finder.find(corner, -1.0 * far, Vec2{wide, high} + far, found);
    const float cell = static_cast<float>(std::max(space.cell_x, space.cell_y));
    for (const SolidFinder::Found& f : found) {
      FluidSolid solid = fluid_solid(f.outline, f.centre, cell);
      if (!std::isfinite((solid.high_x - solid.low_x) + (solid.high_y - solid.low_y))) continue;  // of a broken body
      solid.body = f.id;
      solid.order = f.order;
      by_tile_[t].push_back(solid);
    }
    // Total order: the copies of a shape in a periodic world lie at different places.
    std::ranges::sort(by_tile_[t], [](const FluidSolid& a, const FluidSolid& b) {
      if (a.body != b.body || a.order != b.order) return by_body(a, b);
      return a.centre_x != b.centre_x ? a.centre_x < b.centre_x : a.centre_y < b.centre_y;
    });
  };
  pool.run((keys.size() + kTilesAJob - 1) / kTilesAJob, [&](std::size_t job) {
    std::vector<SolidFinder::Found> found;
    for (std::size_t t = job * kTilesAJob; t < std::min(keys.size(), (job + 1) * kTilesAJob); ++t) look(t, found);
  });
  any_ = std::ranges::any_of(by_tile_, [](const auto& solids) { return !solids.empty(); });
}

void FluidBodies::begin(const SolidFinder* finder, double density, double dt) {
  density_ = density;
  dt_ = dt;
  finder_ = finder != nullptr && finder->any() ? finder : nullptr;
  known_.swap(forces_);
  forces_.clear();
  given_.clear();
  borne_.clear();
}

void FluidBodies::begin_part() {
  around_.clear();
  solids_.clear();
  bodies_.clear();
  tiles_.clear();
  hits_.clear();
  moving_ = false;
}

namespace {

const FluidForce* find_force(const std::vector<FluidForce>& forces, std::uint32_t id, std::uint32_t generation) {
  const auto at = std::ranges::lower_bound(forces, id, {}, &FluidForce::id);
  return at != forces.end() && at->id == id && at->generation == generation ? &*at : nullptr;
}

// The force that a body moved with in this step.
const FluidForce* force_given(const std::vector<FluidForce>& known, std::uint32_t id, std::uint32_t generation) {
  const FluidForce* f = find_force(known, id, generation);
  return f != nullptr && !f->asleep ? f : nullptr;
}

// Sums up the hits of each body, by id. Each sum goes in the order in which hits were taken.
void merge(std::vector<FluidHits>& hits) {
  // Total order: hits of one body stay in their order.
  std::stable_sort(hits.begin(), hits.end(), [](const FluidHits& a, const FluidHits& b) { return a.body < b.body; });
  std::size_t bodies = 0;
  for (std::size_t k = 0; k < hits.size(); ++k) {
    const FluidHits h = hits[k];
    if (bodies == 0 || hits[bodies - 1].body != h.body) hits[bodies++] = {h.body};
    FluidHits& sum = hits[bodies - 1];
    sum = {h.body, sum.x + h.x, sum.y + h.y, sum.turn + h.turn, sum.mass + h.mass, sum.inertia + h.inertia};
  }
  hits.resize(bodies);
}

}  // namespace

// What the parts of this step gave to a body. Before the first part its last force is that of the step before.
FluidForce FluidBodies::so_far(std::uint32_t id, std::uint32_t generation) const {
  if (const FluidForce* f = find_force(given_, id, generation)) return *f;
  FluidForce none{id, generation};
  if (const FluidForce* f = find_force(known_, id, generation)) {
    none.force = f->force;
    none.torque = f->torque;
  }
  return none;
}

// Gives shapes the numbers of their bodies, which are looked up by id.
void FluidBodies::number(TileSolids& of) {
  std::vector<std::uint32_t> ids;
  for (std::size_t t = 0; t < of.size(); ++t) {
    for (const FluidSolid& s : of.at(t)) {
      if (ids.empty() || ids.back() != s.body) ids.push_back(s.body);
    }
  }
  std::ranges::sort(ids);  // Total order: ids that are equal are the same.
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  bodies_.clear();
  for (const std::uint32_t id : ids) bodies_.push_back(finder_->body(id));
  for (std::size_t t = 0; t < of.size(); ++t) {
    for (FluidSolid& s : of.at(t)) {
      s.body = static_cast<std::uint32_t>(std::ranges::lower_bound(ids, s.body) - ids.begin());
    }
  }
}

void FluidBodies::look_around(std::span<const std::uint64_t> keys, const FluidSpace& space, float reach,
                              WorkerPool& pool) {
  if (finder_ == nullptr) return;
  around_.find(*finder_, keys, space, reach, pool);
  number(around_);
}

void FluidBodies::find(std::span<const std::uint64_t> keys, const FluidSpace& space, WorkerPool& pool) {
  constexpr float kReach = 2;  // cells
  solids_.find(*finder_, keys, space, kReach * static_cast<float>(std::max(space.cell_x, space.cell_y)), pool);
  number(solids_);
}

void FluidBodies::look(const FluidGrid& grid, const FluidSpace& space, double part, double known, WorkerPool& pool) {
  share_ = known;
  if (finder_ == nullptr) return;
  find(grid.keys, space, pool);
  tiles_.assign(grid.size(), Tile());
  pulls_.assign(bodies_.size(), Sum());
  // Bodies have moved with all of the last step's force. Here it counts as far as parts of this step have given it; of the
  // next part its share counts, since pressure gives the rest.
  for (FluidBody& b : bodies_) {
    moving_ = moving_ || b.inv_mass > 0;
    const FluidForce given = so_far(b.id, b.generation);
    const FluidForce* moved = force_given(known_, b.id, b.generation);
    const Vec2 push = given.impulse + known * part * given.force - (moved != nullptr ? dt_ * moved->force : Vec2{});
    const double turn = given.spin_impulse + known * part * given.torque - (moved != nullptr ? dt_ * moved->torque : 0);
    const FluidHits hits = borne_by(b.id);
    b.velocity = b.velocity + b.inv_mass * (push + Vec2{hits.x, hits.y});
    b.spin += b.inv_inertia * (turn + hits.turn);
  }
}

Place2 FluidBodies::speed_at(const FluidSolid& solid, Place2 at) const {
  const FluidBody& b = bodies_[solid.body];
  const auto spin = static_cast<float>(b.spin);
  return {static_cast<float>(b.velocity.x) - spin * (at.y - solid.centre_y),
          static_cast<float>(b.velocity.y) + spin * (at.x - solid.centre_x)};
}

bool FluidBodies::keep_out(std::span<const FluidSolid> solids, Place2 from, float dt, float cell, Place2& at,
                           Place2& speed, float mass, std::vector<FluidHits>& hits) const {
  bool changed = false, again = true;
  for (int pass = 0; pass < kMostStops && again; ++pass) {
    again = false;
    for (const FluidSolid& solid : solids) {
      const Place2 moves = speed_at(solid, from);
      const Stop stop = stop_at(solid, {from.x + dt * moves.x, from.y + dt * moves.y}, at, kApartFromShapes * cell,
                                kMostWayOut * cell);
      if (!stop.stopped) continue;
      at = stop.at;
      const Place2 there = speed_at(solid, at);
      const float into = (speed.x - there.x) * stop.out.x + (speed.y - there.y) * stop.out.y;
      if (into < 0) {
        speed = {speed.x - into * stop.out.x, speed.y - into * stop.out.y};
        const std::uint32_t id = bodies_[solid.body].id;
        if (hits.empty() || hits.back().body != id) hits.push_back({id});
        const double push = double{mass} * double{into}, x = push * double{stop.out.x}, y = push * double{stop.out.y};
        hits.back().x += x;
        hits.back().y += y;
        const double arm =
            double{at.x - solid.centre_x} * double{stop.out.y} - double{at.y - solid.centre_y} * double{stop.out.x};
        hits.back().turn += push * arm;
        hits.back().mass += double{mass};
        hits.back().inertia += double{mass} * (arm * arm);
      }
      changed = again = true;
    }
  }
  if (again && stopped_by_fixed(solids, from, at, cell)) at = from;  // shapes that come together leave no place
  return changed;
}

bool FluidBodies::stopped_by_fixed(std::span<const FluidSolid> solids, Place2 from, Place2 to, float cell) const {
  return std::any_of(solids.begin(), solids.end(), [&](const FluidSolid& solid) {
    return !bodies_[solid.body].moves && stop_at(solid, from, to, kApartFromShapes * cell, kMostWayOut * cell).stopped;
  });
}

void FluidBodies::slip_out(std::span<const FluidSolid> solids, float cell, Place2& at) const {
  for (const FluidSolid& solid : solids) {
    if (!bodies_[solid.body].moves) continue;
    Place2 out;
    if (!(solid.distance(at, out) < 0)) continue;
    const float side = (at.x - solid.centre_x) * out.y - (at.y - solid.centre_y) * out.x;
    const float way = side < 0 ? -kMostWayOut * cell : kMostWayOut * cell;
    const Place2 aside{at.x + way * out.y, at.y - way * out.x};
    if (!stopped_by_fixed(solids, at, aside, cell)) at = aside;
  }
}

void FluidBodies::take_hits(const std::vector<FluidHits>& hits, double cell) {
  const double unit = density_ * cell;
  for (const FluidHits& h : hits) {
    hits_.push_back({h.body, unit * h.x, unit * h.y, unit * h.turn, unit * h.mass, unit * h.inertia});
  }
}

FluidHits FluidBodies::borne_by(std::uint32_t id) const {
  const auto at = std::ranges::lower_bound(borne_, id, {}, &FluidHits::body);
  return at != borne_.end() && at->body == id ? *at : FluidHits{id};
}

// Particles were stopped as if a body stood fast. One that is not much heavier than they are bears less, as if they all went
// on with it: else it would be thrown back from what hits it.
void FluidBodies::bear_hits() {
  merge(hits_);
  for (const FluidHits& h : hits_) {
    const auto b = std::ranges::lower_bound(bodies_, h.body, {}, &FluidBody::id);
    if (b == bodies_.end() || b->id != h.body) continue;
    const double share = 1 / (1 + h.mass * b->inv_mass + h.inertia * b->inv_inertia);
    borne_.push_back({h.body, share * h.x, share * h.y, share * h.turn});
  }
  merge(borne_);
}

void FluidBodies::drag(std::uint32_t k, Vec2 impulse, double spin_impulse) {
  FluidBody& b = bodies_[k];
  b.velocity = b.velocity + b.inv_mass * impulse;
  b.spin += b.inv_inertia * spin_impulse;
  borne_.push_back({b.id, impulse.x, impulse.y, spin_impulse});
}

void FluidBodies::draw(FluidGrid& grid, std::size_t tile, const FluidSpace& space) {
  FluidCut(grid, tile, space, *this).run();
}

// Cells which see next to nothing beside a body have no equation, and their rows are missing. The other ones make up for it,
// each by its size.
void FluidBodies::close_surfaces(const FluidGrid& grid) {
  for (float Row::*const part : {&Row::x, &Row::y, &Row::turn}) {
    std::vector<double> sums(bodies_.size()), sizes(bodies_.size());
    const auto each_row = [&](const auto& visit) {
      for (std::size_t t = 0; t < tiles_.size(); ++t) {
        for (const Run& run : tiles_[t].runs) {
          for (std::uint32_t k = run.first; k < run.end; ++k) {
            Row& row = tiles_[t].rows[k];
            if (grid.field(S::kDiagonal, t)[row.node] > 0) visit(row.*part, sums[run.body], sizes[run.body]);
          }
        }
      }
    };
    each_row([](float& a, double& sum, double& size) {
      sum += static_cast<double>(a);
      size += static_cast<double>(std::fabs(a));
    });
    each_row([](float& a, double& sum, double& size) {
      if (size > 0) a -= static_cast<float>(sum / size) * std::fabs(a);
    });
  }
}

float FluidBodies::add_motion(FluidGrid& grid, std::size_t tile) const {
  const float* diagonal = grid.field(S::kDiagonal, tile);
  float* right = grid.field(S::kRight, tile);
  for (const Run& run : tiles_[tile].runs) {
    const FluidBody& b = bodies_[run.body];
    const auto x = static_cast<float>(b.velocity.x), y = static_cast<float>(b.velocity.y),
               turn = static_cast<float>(b.spin);
    for (std::uint32_t k = run.first; k < run.end; ++k) {
      const Row& row = tiles_[tile].rows[k];
      if (diagonal[row.node] > 0) right[row.node] -= row.x * x + row.y * y + row.turn * turn;
    }
  }
  float largest = 0;
  for (std::size_t n = 0; n < kernels::kTileFloats; ++n) {
    if (diagonal[n] > 0) largest = std::max(largest, std::fabs(right[n]));
  }
  return largest;
}

// The sums of all rows times a field, by body. Tiles are taken in their order.
void FluidBodies::sum_rows(FluidGrid& grid, std::size_t x) {
  solver_.each_tile([&](std::size_t t) {
    const float *field = grid.field(x, t), *diagonal = grid.field(S::kDiagonal, t);
    for (Run& run : tiles_[t].runs) {
      run.x = run.y = run.turn = 0;
      for (std::uint32_t k = run.first; k < run.end; ++k) {
        const Row& row = tiles_[t].rows[k];
        const auto value = diagonal[row.node] > 0 ? static_cast<double>(field[row.node]) : 0.0;
        run.x += static_cast<double>(row.x) * value;
        run.y += static_cast<double>(row.y) * value;
        run.turn += static_cast<double>(row.turn) * value;
      }
    }
  });
  sums_.assign(bodies_.size(), Sum());
  for (const Tile& tile : tiles_) {
    for (const Run& run : tile.runs) {
      Sum& sum = sums_[run.body];
      sum.x += run.x;
      sum.y += run.y;
      sum.turn += run.turn;
      sum.met = true;
    }
  }
}

double FluidBodies::apply(FluidGrid& grid, std::size_t x, std::size_t change) {
  sum_rows(grid, x);
  gains_ = sums_;
  double product = 0;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const double per_mass = density_ * bodies_[k].inv_mass, per_inertia = density_ * bodies_[k].inv_inertia;
    Sum& gain = gains_[k];
    gain.x *= per_mass;
    gain.y *= per_mass;
    gain.turn *= per_inertia;
    product += sums_[k].x * gain.x + sums_[k].y * gain.y + sums_[k].turn * gain.turn;
  }
  solver_.each_tile([&](std::size_t t) {
    float* to = grid.field(change, t);
    const float* diagonal = grid.field(S::kDiagonal, t);
    for (const Run& run : tiles_[t].runs) {
      const Sum& gain = gains_[run.body];
      if (!(bodies_[run.body].inv_mass > 0) && !(bodies_[run.body].inv_inertia > 0)) continue;
      const auto gx = static_cast<float>(gain.x), gy = static_cast<float>(gain.y), gt = static_cast<float>(gain.turn);
      for (std::uint32_t k = run.first; k < run.end; ++k) {
        const Row& row = tiles_[t].rows[k];
        if (diagonal[row.node] > 0) to[row.node] += row.x * gx + row.y * gy + row.turn * gt;
      }
    }
  });
  return product;
}

void FluidBodies::bear(FluidGrid& grid, std::size_t pressure, double part) {
  if (any()) sum_rows(grid, pressure);
  bear_hits();
  next_.clear();
  const auto add = [&](std::uint32_t id, std::uint32_t generation, Vec2 pushed, double turned) {
    FluidForce f = so_far(id, generation);
    const bool met = pushed != Vec2{} || turned != 0;
    const Vec2 impulse = pushed + share_ * part * f.force;
    const double spin_impulse = turned + share_ * part * f.torque;
    f.impulse = f.impulse + impulse;
    f.spin_impulse += spin_impulse;
    f.force = met ? (1 / part) * impulse : Vec2{};
    f.torque = met ? spin_impulse / part : 0;
    next_.push_back(f);
  };
  // Those that had a force and are met no more come in between, by id.
  const std::vector<FluidForce>& had = given_.empty() ? known_ : given_;
  std::size_t k = 0;
  const auto add_until = [&](std::uint32_t id) {
    for (; k < had.size() && had[k].id < id; ++k) add(had[k].id, had[k].generation, {}, 0);
    if (k < had.size() && had[k].id == id) ++k;
  };
  for (std::size_t b = 0; b < bodies_.size() && any(); ++b) {
    add_until(bodies_[b].id);
    const Sum &sum = sums_[b], &pull = pulls_[b];
    add(bodies_[b].id, bodies_[b].generation, density_ * Vec2{sum.x + pull.x, sum.y + pull.y},
        density_ * (sum.turn + pull.turn));
  }
  add_until(~0u);
  given_.swap(next_);
}

void FluidBodies::finish() {
  for (const FluidForce& given : given_) {
    const FluidForce* moved = force_given(known_, given.id, given.generation);
    FluidForce f = given;
    if (given.force != Vec2{} || given.torque != 0) {
      f.force = (1 / dt_) * given.impulse;
      f.torque = given.spin_impulse / dt_;
    }
    if (moved != nullptr) {
      f.impulse = f.impulse - dt_ * moved->force;
      f.spin_impulse -= dt_ * moved->torque;
    }
    // Hits are part of the impulse alone: a particle that struck in this step does not push again in the next one.
    const FluidHits hits = borne_by(f.id);
    f.impulse = f.impulse + Vec2{hits.x, hits.y};
    f.spin_impulse += hits.turn;
    const auto b = std::ranges::lower_bound(bodies_, f.id, {}, &FluidBody::id);
    const bool there = b != bodies_.end() && b->id == f.id;
    f.asleep = there && b->asleep;
    const FluidForce* before = find_force(known_, f.id, f.generation);
    f.slow = there && b->speed <= kSlow ? (before != nullptr ? before->slow : 0) + dt_ : 0;
    if (before != nullptr && before->asleep && f.asleep) {
      f.rest_force = before->rest_force;
      f.rest_torque = before->rest_torque;
      f.stir_force = before->stir_force;
      f.stir_torque = before->stir_torque;
    }
    if (!there && before != nullptr && before->asleep && before->rest_force != Vec2{}) {
      f.asleep = true;  // for one more step: the fluid that bore it is gone
      f.stir_force = -1.0 * before->rest_force;
    } else if (f.asleep) {
      // The impulse of this step holds what particles gave that struck the body.
      f.stir_force = f.stir_force + kStirring * ((1 / dt_) * f.impulse - f.rest_force - f.stir_force);
      f.stir_torque += kStirring * (f.spin_impulse / dt_ - f.rest_torque - f.stir_torque);
    }
    const bool pushes = f.force != Vec2{} || f.torque != 0 || f.impulse != Vec2{} || f.spin_impulse != 0;
    if (pushes || f.asleep) forces_.push_back(f);
  }
}

void FluidBodies::clear() {
  around_.clear();
  solids_.clear();
  bodies_.clear();
  tiles_.clear();
  known_.clear();
  given_.clear();
  forces_.clear();
}

std::size_t FluidBodies::bytes() const {
  const std::size_t forces = forces_.capacity() + known_.capacity() + given_.capacity() + next_.capacity();
  return bodies_.capacity() * sizeof(FluidBody) + forces * sizeof(FluidForce);
}

}  // namespace psim
