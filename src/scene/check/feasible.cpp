// Joints that cannot all keep what they say: chains and nets that do not reach from one support to the next or have no
// slack, loops that cannot close, rods shorter than bodies and walls allow. O(n log n) for n joints.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <queue>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "base/rotor.h"
#include "check/rules.h"
#include "number_text.h"
#include "place/links.h"
#include "place/shape_size.h"

namespace psim {
namespace {

constexpr double kShort = 1e-4;         // of a distance: what is missing without a word
constexpr double kSlack = 1e-3;         // of a distance: less slack than this is none
constexpr std::size_t kMostSteps = 64;  // joints that are looked at to find the way round a loop

// The ways through joints between the anchors of a scene's bodies, of those that keep a distance.
class Ways {
 public:
  Ways(const Scene& scene, const Survey& survey) : scene_(scene), bodies_(scene), joints_(all_joints(scene)) {
    for (const PlacedBody& b : survey.bodies) {
      if (b.id >= scene.bodies.size()) place_[b.id] = {b.x, b.y};
    }
    for (std::size_t k = 0; k < joints_.size(); ++k) {
      if (!keeps(k)) continue;
      at_[joints_[k].a].push_back(k);
      at_[joints_[k].b].push_back(k);
    }
  }

  std::size_t count() const { return joints_.size(); }
  const SceneJoint& joint(std::size_t k) const { return joints_[k]; }
  bool keeps(std::size_t k) const {
    const JointType type = joints_[k].joint.type;
    return type == JointType::revolute || type == JointType::weld || is_rod(k);
  }
  bool is_rod(std::size_t k) const {
    return joints_[k].joint.type == JointType::rope || is_rigid_rod(joints_[k].joint);
  }
  bool moves(std::uint64_t id) const { return bodies_.type_of(id) == BodyType::dynamic_body; }
  const BodyDesc& desc_of(std::uint64_t id) const { return bodies_.desc_of(id); }
  Vec2 anchor(std::size_t k, std::uint64_t id) const {
    return id == joints_[k].a ? joints_[k].joint.anchor_a : joints_[k].joint.anchor_b;
  }
  Vec2 place(std::size_t k, std::uint64_t id) const {
    const bool own = id < scene_.bodies.size() || id == kWorldSide;
    const Vec2 at = own ? desc_of(id).position : place_.at(id);
    return to_world(anchor(k, id), at, desc_of(id).angle);
  }
  double length(std::size_t k) const {
    if (!is_rod(k)) return 0;
    if (joints_[k].joint.length) return *joints_[k].joint.length;
    const Vec2 a = place(k, joints_[k].a), b = place(k, joints_[k].b);
    return length_of(b - a);
  }
  std::uint64_t other(std::size_t k, std::uint64_t id) const {
    return joints_[k].a == id ? joints_[k].b : joints_[k].a;
  }
  const std::vector<std::size_t>& of(std::uint64_t id) const {
    static const std::vector<std::size_t> none;
    const auto it = at_.find(id);
    return it == at_.end() ? none : it->second;
  }
  // Between the anchors of two joints of a body.
  double inside(std::uint64_t id, std::size_t in, std::size_t out) const {
    const Vec2 a = anchor(in, id), b = anchor(out, id);
    return length_of(b - a);
  }

 private:
  const Scene& scene_;
  SceneBodies bodies_;
  std::vector<SceneJoint> joints_;
  std::unordered_map<std::uint64_t, Vec2> place_;  // of bodies of groups; for look-up only
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> at_;
};

// The shortest way found so far to an anchor of a body.
struct Reach {
  double length = 0;
  std::uint64_t body = 0;
  std::size_t joint = 0;    // by which it was reached
  std::size_t support = 0;  // the joint with which the way began
  bool operator<(const Reach& o) const { return length != o.length ? length > o.length : joint > o.joint; }
};

// Ways that meet between two supports: from each to the nearest bodies (Dijkstra 1959), and one joint between these.
void check_supports(const Scene& scene, const Ways& ways, Lines& lines) {
  std::priority_queue<Reach> ahead;  // a total order: by length, then joint
  std::unordered_map<std::uint64_t, Reach> reached;
  const auto held = [&](std::size_t k) { return ways.moves(ways.joint(k).a) ? ways.joint(k).b : ways.joint(k).a; };
  for (std::size_t k = 0; k < ways.count(); ++k) {
    const SceneJoint& j = ways.joint(k);
    if (!ways.keeps(k) || ways.moves(j.a) == ways.moves(j.b)) continue;
    ahead.push({ways.length(k), ways.other(k, held(k)), k, k});
  }
  double worst = kSlack, far = 0, way = 0;
  std::pair<std::size_t, std::size_t> supports;
  std::set<std::pair<std::size_t, std::size_t>> tight;
  while (!ahead.empty()) {
    const Reach at = ahead.top();
    ahead.pop();
    const auto [it, first] = reached.try_emplace(at.body, at);
    if (!first) {
      const Reach& met = it->second;
      if (met.support == at.support) continue;
      const double all = at.length + met.length + ways.inside(at.body, at.joint, met.joint);
      const Vec2 g = scene.world.gravity, a = ways.place(at.support, held(at.support)),
                 b = ways.place(met.support, held(met.support));
      const double apart = length_of(b - a);
      const double across = std::fabs(g.x * (b.y - a.y) - g.y * (b.x - a.x));
      const double slack = apart > 0 ? all / apart - 1 : 1;
      if (slack >= kSlack || (slack > -kShort && across <= 1e-9 * apart)) continue;
      const std::pair<std::size_t, std::size_t> both = std::minmax(at.support, met.support);
      tight.insert(both);
      if (slack >= worst) continue;
      worst = slack, far = apart, way = all;
      supports = both;
      continue;
    }
    for (const std::size_t k : ways.of(at.body)) {
      const std::uint64_t next = ways.other(k, at.body);
      if (k == at.joint || !ways.moves(next)) continue;
      const double length = at.length + ways.inside(at.body, at.joint, k) + ways.length(k);
      const auto met = reached.find(next);
      if (met == reached.end() || met->second.support != at.support) ahead.push({length, next, k, at.support});
    }
  }
  if (tight.empty()) return;
  const std::string where = "joints " + std::to_string(supports.first) + " and " + std::to_string(supports.second) +
                            (tight.size() > 1 ? " (the worst of " + std::to_string(tight.size()) + ")" : "");
  if (worst < -kShort) {
    lines.push_back(where + ": the way through joints from one support to the other is " + number_text(way) +
                    " m long, and they are " + number_text(far) +
                    " m apart: joints will stretch; bring the supports nearer or make lengths larger");
  } else {
    lines.push_back(where + ": the way through joints from one support to the other has no slack over " +
                    number_text(far) +
                    " m, so that no force can hold what hangs on it: joints will stretch a little; "
                    "make it a few per cent longer");
  }
}

// Whether joints keep the anchors of joint k nearer to each other than its length: the length of that way, or that of k.
double way_round(const Ways& ways, std::size_t k) {
  const double length = ways.length(k);
  const SceneJoint& j = ways.joint(k);
  std::priority_queue<Reach> ahead;  // a total order: by length, then joint
  std::unordered_map<std::uint64_t, double> reached;
  ahead.push({0, j.a, k, k});
  for (std::size_t steps = 0; !ahead.empty() && steps < kMostSteps;) {
    const Reach at = ahead.top();
    ahead.pop();
    if (!reached.try_emplace(at.body, at.length).second) continue;
    for (const std::size_t next : ways.of(at.body)) {
      if (next == k || next == at.joint) continue;
      const std::uint64_t body = ways.other(next, at.body);
      double way = at.length + ways.inside(at.body, at.joint, next) + ways.length(next);
      if (body == j.b) {
        way += ways.inside(body, next, k);
        if (way < length) return way;
      }
      ++steps;
      if (way < length && body != j.b) ahead.push({way, body, next, k});
    }
  }
  return length;
}

void check_loops(const Ways& ways, Lines& lines) {
  for (std::size_t k = 0; k < ways.count(); ++k) {
    const SceneJoint& j = ways.joint(k);
    if (!is_rigid_rod(j.joint) || !j.joint.length) continue;
    const double way = way_round(ways, k), length = *j.joint.length;
    if (way >= length * (1 - kShort)) continue;
    lines.push_back("joints[" + std::to_string(k) + "]: its length is " + number_text(length) +
                    " m, but other joints keep its anchors within " + number_text(way) +
                    " m: the loop cannot close, and all its joints will be off; make lengths agree");
  }
}

// Rods that are shorter than two discs, or a disc and the walls, allow.
void check_room(const Scene& scene, const Ways& ways, Lines& lines) {
  const auto radius = [&](std::uint64_t id) {
    const auto* disc = std::get_if<DiscShape>(&ways.desc_of(id).shape);
    return disc ? disc->radius : -1.0;
  };
  for (std::size_t k = 0; k < ways.count(); ++k) {
    const SceneJoint& j = ways.joint(k);
    if (!ways.is_rod(k) || !j.joint.length) continue;
    const double length = *j.joint.length, arms = length_of(j.joint.anchor_a) + length_of(j.joint.anchor_b);
    const double touch = radius(j.a) + radius(j.b);
    if (j.joint.collide && radius(j.a) > 0 && radius(j.b) > 0 && length + arms < touch * (1 - kShort)) {
      lines.push_back("joints[" + std::to_string(k) + "]: its length is " + number_text(length) +
                      " m, but its bodies touch at " + number_text(touch) +
                      " m and collide: they will press on each other; make it longer or collide false");
    }
    const bool a_moves = ways.moves(j.a), one = a_moves != ways.moves(j.b);
    const double r = radius(a_moves ? j.a : j.b);
    if (!one || r <= 0 || scene.world.boundary != Boundary::walls) continue;
    const Vec2 p = ways.place(k, a_moves ? j.b : j.a);
    const Bounds& b = scene.world.bounds;
    const double arm = length_of(a_moves ? j.joint.anchor_a : j.joint.anchor_b);
    const double x = std::max({b.xmin + r - p.x, p.x - (b.xmax - r), 0.0});
    const double y = std::max({b.ymin + r - p.y, p.y - (b.ymax - r), 0.0});
    if (length_of({x, y}) <= (length + arm) * (1 + kShort)) continue;
    lines.push_back("joints[" + std::to_string(k) + "]: its length is " + number_text(length) +
                    " m, but a disc of radius " + number_text(r) + " m between the walls stays " +
                    number_text(length_of({x, y})) +
                    " m from its anchor: the wall and the joint will pull; make it longer");
  }
}

}  // namespace

void check_feasible(const Scene& scene, const Survey& survey, Lines& lines) {
  if (!survey.misplaced.empty()) return;  // ids behind those are not known
  const Ways ways(scene, survey);
  check_supports(scene, ways, lines);
  check_loops(ways, lines);
  check_room(scene, ways, lines);
}

}  // namespace psim
