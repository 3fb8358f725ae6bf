#include "sph_grid.h"

#include <algorithm>
#include <cmath>

namespace psim::fluids {
namespace {

constexpr float kFar = 1e6f;         // beyond every kernel
constexpr double kSlackShare = 0.1;  // of the reach: cells are so much wider than the kernel reaches

}  // namespace

void SphColumns::resize(std::size_t slots) {
  for (auto* column : {&x, &y}) column->assign(slots + kLanes, kFar);
  for (auto* column : {&vx, &vy, &drift_x, &drift_y, &strain, &volume, &pressure, &fluid}) {
    column->assign(slots + kLanes, 0.0f);
  }
}

SphGrid::SphGrid(const Flow& flow, double reach)
    : periodic_(flow.boundary == Boundary::periodic),
      width_(flow.bounds.xmax - flow.bounds.xmin),
      height_(flow.bounds.ymax - flow.bounds.ymin),
      wall_volume_(static_cast<float>(flow.spacing * flow.spacing)),
      side_(reach * (1 + kSlackShare)),
      margin_(2 * side_),
      slack_(reach * kSlackShare / 2) {
  across = static_cast<std::uint32_t>((width_ + 2 * margin_) / side_) + 2;
  up_ = static_cast<std::uint32_t>((height_ + 2 * margin_) / side_) + 2;
  if (flow.boundary == Boundary::walls) make_walls(flow, reach);
}

// Dummy particles in as many layers as the kernel reaches, on a lattice that goes on from the one of the fluid.
void SphGrid::make_walls(const Flow& flow, double reach) {
  const double d = flow.spacing;
  const int layers = static_cast<int>(std::ceil(reach / d));
  const int columns = static_cast<int>(std::lround(width_ / d)), rows = static_cast<int>(std::lround(height_ / d));
  for (int j = -layers; j < rows + layers; ++j) {
    for (int i = -layers; i < columns + layers; ++i) {
      if (i >= 0 && i < columns && j >= 0 && j < rows) continue;
      walls_.push_back({(i + 0.5) * width_ / columns, (j + 0.5) * height_ / rows});
    }
  }
}

// Cells on the rim have no particles to look for neighbours: each other cell has eight around it.
std::uint32_t SphGrid::cell_of(double x, double y) const {
  const auto place = [](double at, std::uint32_t cells) {
    return static_cast<std::uint32_t>(std::clamp(at, 1.0, cells - 2.0));
  };
  return place((y + margin_) / side_, up_) * across + place((x + margin_) / side_, across);
}

void SphGrid::make_copies(std::vector<SphParticle>& particles) {
  copies_.clear();
  for (std::uint32_t k = 0; k < particles.size(); ++k) {
    SphParticle& p = particles[k];
    p.x -= width_ * std::floor(p.x / width_);
    p.y -= height_ * std::floor(p.y / height_);
    for (int b = -1; b <= 1; ++b) {
      for (int a = -1; a <= 1; ++a) {
        const double x = p.x + a * width_, y = p.y + b * height_;
        const bool near = x > -side_ && x < width_ + side_ && y > -side_ && y < height_ + side_;
        if (near && (a != 0 || b != 0)) copies_.push_back({k, a * width_, b * height_, 0});
      }
    }
  }
}

void SphGrid::sort(std::vector<SphParticle>& particles) {
  if (periodic_) make_copies(particles);
  const std::size_t fluid = particles.size(), moving = fluid + copies_.size(), all = moving + walls_.size();
  std::vector<std::uint32_t> cell_of_all(all), slot_of_all(all);
  for (std::size_t k = 0; k < fluid; ++k) cell_of_all[k] = cell_of(particles[k].x, particles[k].y);
  for (std::size_t k = fluid; k < moving; ++k) {
    const Copy& c = copies_[k - fluid];
    cell_of_all[k] = cell_of(particles[c.particle].x + c.shift_x, particles[c.particle].y + c.shift_y);
  }
  for (std::size_t k = moving; k < all; ++k) cell_of_all[k] = cell_of(walls_[k - moving].x, walls_[k - moving].y);

  start.assign(std::size_t{across} * up_ + 1, 0);
  for (const std::uint32_t c : cell_of_all) ++start[c + 1];
  for (std::size_t c = 1; c < start.size(); ++c) {
    const bool row_ends = c % across == 0;
    start[c] += start[c - 1] + (row_ends ? static_cast<std::uint32_t>(kLanes) : 0);
  }
  const std::uint32_t slots = start.back();
  std::vector<std::uint32_t> next(start.begin(), start.end() - 1), particle_in(slots, ~0u);
  for (std::uint32_t k = 0; k < all; ++k) {
    slot_of_all[k] = next[cell_of_all[k]]++;
    if (k < fluid) particle_in[slot_of_all[k]] = k;
  }

  std::vector<SphParticle> sorted;
  std::vector<std::uint32_t> now(fluid);
  sorted.reserve(fluid), slot.clear(), cell.clear(), sorted_at_.clear();
  for (std::uint32_t s = 0; s < slots; ++s) {
    if (particle_in[s] == ~0u) continue;
    const SphParticle& p = particles[particle_in[s]];
    now[particle_in[s]] = static_cast<std::uint32_t>(sorted.size());
    slot.push_back(s), cell.push_back(cell_of_all[particle_in[s]]), sorted_at_.push_back({p.x, p.y});
    sorted.push_back(p);
  }
  particles.swap(sorted);
  for (std::size_t k = fluid; k < moving; ++k) {
    copies_[k - fluid].particle = now[copies_[k - fluid].particle];
    copies_[k - fluid].slot = slot_of_all[k];
  }
  columns.resize(slots);
  wall_slot.assign(slot_of_all.begin() + static_cast<std::ptrdiff_t>(moving), slot_of_all.end());
  wall_cell.assign(cell_of_all.begin() + static_cast<std::ptrdiff_t>(moving), cell_of_all.end());
  for (std::size_t k = 0; k < walls_.size(); ++k) {
    columns.x[wall_slot[k]] = static_cast<float>(walls_[k].x);
    columns.y[wall_slot[k]] = static_cast<float>(walls_[k].y);
    columns.volume[wall_slot[k]] = wall_volume_;
  }
  for (std::size_t k = 0; k < fluid; ++k) columns.fluid[slot[k]] = 1;
  for (const Copy& c : copies_) columns.fluid[c.slot] = 1;
}

void SphGrid::load(const std::vector<SphParticle>& particles) {
  SphColumns& c = columns;
  const auto put = [&](const SphParticle& p, std::uint32_t s, double shift_x, double shift_y) {
    c.x[s] = static_cast<float>(p.x + shift_x), c.y[s] = static_cast<float>(p.y + shift_y);
    c.vx[s] = static_cast<float>(p.vx), c.vy[s] = static_cast<float>(p.vy);
    c.drift_x[s] = static_cast<float>(p.drift_x), c.drift_y[s] = static_cast<float>(p.drift_y);
    c.strain[s] = static_cast<float>(p.strain);
  };
  for (std::size_t k = 0; k < particles.size(); ++k) put(particles[k], slot[k], 0, 0);
  for (const Copy& copy : copies_) put(particles[copy.particle], copy.slot, copy.shift_x, copy.shift_y);
}

void SphGrid::load_copies() {
  for (const Copy& copy : copies_) {
    columns.strain[copy.slot] = columns.strain[slot[copy.particle]];
    columns.volume[copy.slot] = columns.volume[slot[copy.particle]];
    columns.pressure[copy.slot] = columns.pressure[slot[copy.particle]];
  }
}

bool SphGrid::stale(const std::vector<SphParticle>& particles) const {
  if (sorted_at_.size() != particles.size()) return true;
  for (std::size_t k = 0; k < particles.size(); ++k) {
    const double x = particles[k].x - sorted_at_[k].x, y = particles[k].y - sorted_at_[k].y;
    if (x * x + y * y > slack_ * slack_) return true;
  }
  return false;
}

}  // namespace psim::fluids
