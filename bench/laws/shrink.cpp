#include "shrink.h"

#include <functional>
#include <stdexcept>
#include <utility>

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

class Shrinker {
 public:
  Shrinker(const Law& law, Scene scene, int tries) : law_(law), scene_(std::move(scene)), tries_(tries) {}

  Scene done() {
    for (bool smaller = true; smaller && tries_ > 0;) {
      smaller = fewer();
      simpler();
    }
    return scene_;
  }

 private:
  bool keep_if_broken(const Scene& scene) {
    if (tries_-- <= 0 || scene.bodies.empty()) return false;
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
