#include "model/catalogue.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "place/links.h"
#include "place/shape_size.h"

namespace psim::view {
namespace {

// m^2, of the points and the radius around them; for a line its length, m.
double area_of(const Kind& kind) {
  const std::size_t n = kind.points.size();
  double twice = 0, around = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const Vec2 p = kind.points[k], q = kind.points[(k + 1) % n];
    twice += p.x * q.y - p.y * q.x;
    around += std::hypot(q.x - p.x, q.y - p.y);
  }
  if (kind.line) return around / 2;
  const double r = kind.radius;
  return std::fabs(twice) / 2 + around * r + std::numbers::pi * r * r;
}

std::string key_of(const Kind& kind) {
  std::string key(reinterpret_cast<const char*>(kind.points.data()), kind.points.size() * sizeof(Vec2));
  key.append(reinterpret_cast<const char*>(&kind.radius), sizeof kind.radius);
  key += kind.line ? 'l' : 'a';
  key += kind.loop ? 'o' : '-';
  key.append(reinterpret_cast<const char*>(&kind.area), sizeof kind.area);
  key.append(reinterpret_cast<const char*>(kind.parts.data()), kind.parts.size() * sizeof kind.parts[0]);
  return key;
}

}  // namespace

Catalogue::Catalogue(const Scene& scene) {
  const SceneBodies bodies(scene);
  const std::size_t n = scene.body_count();
  looks_.reserve(n);
  for (std::size_t id = 0; id < scene.bodies.size(); ++id) {
    set(static_cast<std::uint32_t>(id), scene.bodies[id], scene.bodies[id].type);
  }
  std::size_t id = scene.bodies.size();
  for (const GroupDesc& group : scene.groups) {
    // One look for the group; some of its bodies may be pinned.
    for (std::uint64_t k = 0; k < group.count; ++k, ++id) {
      if (k == 0 || group.links) {
        set(static_cast<std::uint32_t>(id), group.body, bodies.type_of(id));
      } else {
        looks_.push_back(looks_.back());
        density_.push_back(density_.back());
        mass_.push_back(mass_.back());
      }
    }
  }
}

void Catalogue::hide(std::uint32_t id) {
  set(id, {}, BodyType::static_body);
  if (hidden_kind_ == kKindMask) {
    hidden_kind_ = static_cast<std::uint32_t>(kinds_.size());
    kinds_.push_back({});
  }
  looks_[id] = hidden_kind_ | kStaticBit;  // static: in no scale of colours, without a trail
}

void Catalogue::set(std::uint32_t id, const BodyDesc& body, BodyType type) {
  if (id >= looks_.size()) {
    looks_.resize(id + 1);
    density_.resize(id + 1);
    mass_.resize(id + 1);
  }
  looks_[id] = look_of(body, type);
  density_[id] = static_cast<float>(body.material.density);
  mass_[id] = static_cast<float>(body.mass);
}

// The number of a kind, which others may have, too.
std::uint32_t Catalogue::kind_of(Kind kind) {
  (kind.line ? has_lines_ : has_areas_) = true;
  const auto [at, is_new] = known_.emplace(key_of(kind), static_cast<std::uint32_t>(kinds_.size()));
  if (is_new) kinds_.push_back(std::move(kind));
  return at->second;
}

std::uint32_t Catalogue::look_of(const BodyDesc& body, BodyType type) {
  std::uint32_t look = kDiscKind;
  if (!is_disc(body.shape)) {
    std::vector<Kind> parts;
    for (Outline& o : outlines(body.shape)) {
      double reach = 0;
      for (const Vec2& p : o.points) reach = std::max(reach, std::hypot(p.x, p.y) + o.radius);
      Kind& kind = parts.emplace_back(Kind{std::move(o.points), o.radius, reach, o.line, o.closed, 0, {}});
      kind.area = area_of(kind);
    }
    if (const auto* compound = std::get_if<CompoundShape>(&body.shape)) {
      Kind all;
      for (std::size_t k = 0; k < parts.size(); ++k) {
        all.reach = std::max(all.reach, parts[k].reach);
        all.area += parts[k].area * compound->parts[k].density.value_or(body.material.density) / body.material.density;
        all.line |= parts[k].line;
        all.parts.push_back(kind_of(std::move(parts[k])));
      }
      has_compounds_ = true;
      look = kind_of(std::move(all));
    } else {
      look = kind_of(std::move(parts.front()));
    }
  }
  if (type == BodyType::static_body) look |= kStaticBit;
  if (type == BodyType::kinematic_body) look |= kKinematicBit;
  if (body.sensor) look |= kSensorBit;
  return look;
}

double Catalogue::mass(std::uint32_t id, double disc_radius) const {
  if (id >= looks_.size()) return 0;
  if (mass_[id] > 0) return static_cast<double>(mass_[id]);
  const Kind& shape = kind(id);
  const bool disc = shape.points.empty() && shape.parts.empty();
  const double area = disc ? std::numbers::pi * disc_radius * disc_radius : shape.area;
  return static_cast<double>(density_[id]) * area;
}

}  // namespace psim::view
