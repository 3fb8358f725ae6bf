#include "shrink.h"

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <utility>
#include <variant>

namespace psim::laws {
namespace {

Scene without_body(const Scene& scene, std::size_t id) {
  Scene out = scene;
  out.bodies.erase(out.bodies.begin() + static_cast<std::ptrdiff_t>(id));
  if (!out.body_names.empty()) out.body_names.erase(out.body_names.begin() + static_cast<std::ptrdiff_t>(id));
  std::erase_if(out.joints, [&](const SceneJoint& j) { return j.a == id || j.b == id; });
  for (SceneJoint& j : out.joints) {
    if (j.a > id) --j.a;
    if (j.b > id) --j.b;
  }
  return out;
}

bool may_go(const Law& law, const BodyDesc& body) {
  return law.spare == Spare::all || (law.spare == Spare::movers && body.type == BodyType::dynamic_body);
}

// The area as a rectangle around it; a list as it is.
SceneFluid boxed(SceneFluid fluid) {
  if (const auto* d = std::get_if<FluidDisc>(&fluid.place)) {
    const double x = d->position.x, y = d->position.y, r = d->radius;
    fluid.place = Bounds{x - r, y - r, x + r, y + r};
  } else if (const auto* p = std::get_if<FluidPolygon>(&fluid.place)) {
    Bounds box{1e300, 1e300, -1e300, -1e300};
    for (const Vec2& v : p->vertices) {
      box = {std::min(box.xmin, v.x), std::min(box.ymin, v.y), std::max(box.xmax, v.x), std::max(box.ymax, v.y)};
    }
    fluid.place = box;
  }
  return fluid;
}

// The lower (part 0), left (1) or right (2) half of a fluid. Of a list, part 2 is the second half of the particles and the
// others are the first one.
SceneFluid half_of(const SceneFluid& fluid, int part) {
  SceneFluid out = boxed(fluid);
  if (auto* b = std::get_if<Bounds>(&out.place)) {
    const double x = (b->xmin + b->xmax) / 2;
    if (part == 0) b->ymax = (b->ymin + b->ymax) / 2;
    if (part == 1) b->xmax = x;
    if (part == 2) b->xmin = x;
  } else {
    auto& list = std::get<FluidList>(out.place);
    for (auto* column : {&list.x, &list.y, &list.vx, &list.vy}) {
      const auto middle = column->begin() + static_cast<std::ptrdiff_t>(column->size() / 2);
      *column = part == 2 ? std::vector<double>(middle, column->end()) : std::vector<double>(column->begin(), middle);
    }
  }
  return out;
}

class Shrinker {
 public:
  Shrinker(const Law& law, Scene scene, int tries) : law_(law), scene_(std::move(scene)), tries_(tries) {}

  Scene done() {
    for (bool smaller = true; smaller && tries_ > 0;) {
      smaller = fewer();
      smaller |= less_fluid();
      simpler();
      simpler_fluid();
    }
    return scene_;
  }

 private:
  bool keep_if_broken(const Scene& scene) {
    if (tries_-- <= 0 || (scene.bodies.empty() && scene.fluids.empty())) return false;
    try {
      if (!law_.broken(scene)) return false;
    } catch (const std::exception&) {
      return false;  // what is left is no scene
    }
    scene_ = scene;
    return true;
  }

  bool fewer() {
    bool any = false;
    for (std::size_t id = scene_.bodies.size(); id-- > 0;) {
      if (id < scene_.bodies.size() && may_go(law_, scene_.bodies[id])) any |= keep_if_broken(without_body(scene_, id));
    }
    for (std::size_t k = scene_.joints.size(); k-- > 0 && law_.spare != Spare::nothing;) {
      Scene less = scene_;
      less.joints.erase(less.joints.begin() + static_cast<std::ptrdiff_t>(k));
      any |= keep_if_broken(less);
    }
    return any;
  }

  bool less_fluid() {
    if (law_.spare == Spare::nothing) return false;
    bool any = false;
    for (std::size_t k = scene_.fluids.size(); k-- > 0 && scene_.fluids.size() > 1;) {
      Scene less = scene_;
      less.fluids.erase(less.fluids.begin() + static_cast<std::ptrdiff_t>(k));
      any |= keep_if_broken(less);
    }
    for (std::size_t k = 0; k < scene_.fluids.size(); ++k) {
      for (int part = 0; part < 3; ++part) {
        Scene less = scene_;
        less.fluids[k] = half_of(scene_.fluids[k], part);
        any |= keep_if_broken(less);
      }
    }
    return any;
  }

  void simpler_fluid() {
    const std::vector<std::function<void(SceneFluid&)>> edits = {
        [](SceneFluid& f) { f.fluid.viscosity = 0; }, [](SceneFluid& f) { f.fluid.surface_tension = 0; },
        [](SceneFluid& f) { f.velocity = {}; }, [](SceneFluid& f) { f.fluid.density = 1000; }};
    if (law_.spare == Spare::nothing) return;
    for (std::size_t k = 0; k < scene_.fluids.size(); ++k) {
      for (const auto& edit : edits) {
        Scene other = scene_;
        edit(other.fluids[k]);
        keep_if_broken(other);
      }
    }
  }

  void simpler() {
    const std::vector<std::function<void(BodyDesc&)>> edits = {
        [](BodyDesc& b) { b.material.friction = 0; },    [](BodyDesc& b) { b.angular_velocity = 0; },
        [](BodyDesc& b) { b.material.restitution = 0; }, [](BodyDesc& b) { b.material.density = 1; },
        [](BodyDesc& b) { b.shape = DiscShape{0.5}; },   [](BodyDesc& b) { b.angle = 0; }};
    if (law_.spare == Spare::nothing) return;
    for (std::size_t id = 0; id < scene_.bodies.size(); ++id) {
      if (scene_.bodies[id].type != BodyType::dynamic_body) continue;
      for (const auto& edit : edits) {
        Scene other = scene_;
        edit(other.bodies[id]);
        keep_if_broken(other);
      }
    }
  }

  const Law& law_;
  Scene scene_;
  int tries_;
};

}  // namespace

Scene shrunk(const Law& law, Scene scene, int tries) { return Shrinker(law, std::move(scene), tries).done(); }

}  // namespace psim::laws
