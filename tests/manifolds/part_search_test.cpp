// The search for parts against a look at all of them: whatever may touch while the lists last is found.
#include "manifolds/part_search.h"

#include "bodies/population.h"
#include "collide/collide.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

struct Setting {
  explicit Setting(bool periodic) : desc(periodic ? test::periodic(64, 64) : unbounded(32)) {}

  std::uint32_t put(const BodyDesc& body) {
    std::string error;
    const BodyId id = population.add(body, error);
    if (id == kNoBody) throw std::runtime_error(error);
    return bodies.info[id.index].slot;
  }

  /// Margins of all bodies, as the broad phase gives them.
  void make_lists(const kernels::ReachParams& margin) {
    bodies.reach.reserve(bodies.count);
    bodies.built.reserve(2 * std::size_t{bodies.count});
    std::vector<std::uint32_t> slots;
    for (std::uint32_t i = 0; i < bodies.count; ++i) {
      const Vec2 v = bodies.velocity(i);
      bodies.reach[i] = bodies.radius[i] + margin.skin + static_cast<float>(std::hypot(v.x, v.y)) * margin.time;
      slots.push_back(i);
    }
    std::copy_n(bodies.pos.data(), 2 * std::size_t{bodies.count}, bodies.built.data());
    search.note(slots, margin, 0, true);
    search.prepare();
  }

  /// Moves and turns all bodies as far as their lists allow.
  void go_to_the_limit(Random& random, const kernels::ReachParams& margin) {
    for (std::uint32_t i = 0; i < bodies.count; ++i) {
      const double way = 0.999 * random.uniform(0.9, 1) * (double{bodies.reach[i]} - double{bodies.radius[i]});
      const double to = random.uniform(0, 2 * kPi);
      const std::size_t at = 2 * std::size_t{i};
      bodies.put_point(i, {bodies.built[at], bodies.built[at + 1], static_cast<float>(way * std::cos(to)),
                           static_cast<float>(way * std::sin(to))});
      const double turn = double{margin.skin} + double{std::fabs(bodies.rim_speed[i])} * double{margin.time};
      bodies.angle[i] += (random.chance(0.5) ? 0.999 : -0.999) * turn / double{bodies.radius[i]};
    }
  }

  double gap(std::uint32_t i, std::uint32_t part_i, std::uint32_t j, std::uint32_t part_j) const {
    const auto hull = [&](std::uint32_t slot, std::uint32_t part) {
      const BodyKind& kind = bodies.kind(bodies.id[slot]);
      return kind.hull_count == 0 ? disc_hull(bodies.radius[slot]) : bodies.hulls[kind.first_hull + part];
    };
    const Vec2 way = lattice.way(bodies.point(i), bodies.point(j));
    return double{nearest(hull(i, part_i), rotor_of(bodies.angle[i]), hull(j, part_j), rotor_of(bodies.angle[j]),
                          static_cast<float>(way.x), static_cast<float>(way.y))
                      .distance};
  }
  std::uint32_t parts(std::uint32_t slot) const { return std::max(1u, bodies.kind(bodies.id[slot]).hull_count); }

  WorldDesc desc;
  Lattice lattice{desc.bounds, desc.boundary == Boundary::periodic};
  MemoryMeter memory;
  Population population{desc, lattice, memory};
  BodyStore& bodies = population.bodies;
  kernels::KernelTable kernels = kernels_of(best_isa());
  WorkerPool pool{1};
  Surroundings surroundings{memory,      lattice,  bodies, population.statics, kernels, pool, population.kinematics,
                            desc.mixing, desc.wall};
  PartSearch search{surroundings};
};

BodyDesc outline(Random& random, int segments, double radius) {
  std::vector<Vec2> v = regular(segments, radius);
  for (Vec2& p : v) p = {p.x * random.uniform(0.7, 1.3), p.y * random.uniform(0.7, 1.3)};
  BodyDesc body;
  body.shape = ChainShape{v, true};
  body.type = BodyType::kinematic_body;
  body.position = {random.uniform(-4, 4), random.uniform(-4, 4)};
  body.angle = random.uniform(-9, 9);
  body.angular_velocity = random.uniform(-3, 3);
  body.velocity = {random.uniform(-3, 3), random.uniform(-3, 3)};
  return body;
}

TEST(PartSearch, FindsAllThatMayTouchWhileListsLast) {
  std::uint64_t touching = 0, found = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    Random random(seed);
    Setting s(seed % 3 == 0);
    const std::uint32_t wide = s.put(outline(random, 10 + static_cast<int>(random.below(90)), random.uniform(2, 9)));
    const std::uint32_t other = s.put(outline(random, 10 + static_cast<int>(random.below(40)), random.uniform(1, 5)));
    std::vector<std::uint32_t> small;
    for (int k = 0; k < 40; ++k) {
      const Vec2 at{random.uniform(-12, 12), random.uniform(-12, 12)}, v{random.uniform(-4, 4), random.uniform(-4, 4)};
      small.push_back(s.put(random.chance(0.5) ? moving(box(at, random.uniform(0.1, 1), random.uniform(0.1, 1)), v)
                                               : disc(at, v, random.uniform(0.05, 0.6))));
    }
    s.bodies.keep_rotation(true);
    const kernels::ReachParams margin{.skin = static_cast<float>(random.uniform(0.01, 0.1)),
                                      .time = static_cast<float>(random.uniform(0.01, 0.05))};
    s.make_lists(margin);
    ASSERT_TRUE(s.search.has(wide) && s.search.has(other) && !s.search.has(small[0]));
    EXPECT_TRUE(s.search.serve(0));
    EXPECT_FALSE(s.search.serve(10));
    s.go_to_the_limit(random, margin);
    EXPECT_TRUE(s.search.serve(0));
    EXPECT_FALSE(s.search.serve(0.01f));
    std::vector<std::uint32_t> near;
    const auto expect_found = [&](std::uint32_t slot, std::uint32_t partner, std::uint32_t partner_part) {
      ASSERT_TRUE(std::ranges::is_sorted(near, std::ranges::less_equal{}) || near.size() < 2);
      found += near.size();
      all += s.parts(slot);
      for (std::uint32_t k = 0; k < s.parts(slot); ++k) {
        if (s.gap(slot, k, partner, partner_part) > 0) continue;
        ++touching;
        ASSERT_TRUE(std::ranges::binary_search(near, k)) << "seed " << seed << ", part " << k;
      }
    };
    for (const std::uint32_t partner : small) {
      near.clear();
      s.search.near_body(wide, partner, near);
      expect_found(wide, partner, 0);
    }
    for (std::uint32_t part = 0; part < s.parts(other); ++part) {
      near.clear();
      s.search.near_part(wide, other, part, near);
      expect_found(wide, other, part);
    }
  }
  EXPECT_GT(touching, 1000u);
  EXPECT_LT(found, all / 4);
}

TEST(PartSearch, FindsThePartsNearFixedShapesAndWalls) {
  std::uint64_t touching = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    Setting s(false);
    const std::uint32_t wide = s.put(outline(random, 10 + static_cast<int>(random.below(90)), random.uniform(2, 9)));
    std::string error;
    for (int k = 0; k < 30; ++k) {
      const Vec2 at{random.uniform(-12, 12), random.uniform(-12, 12)};
      BodyDesc body = random.chance(0.3)   ? segment({0, 0}, {random.uniform(-9, 9), random.uniform(-9, 9)})
                      : random.chance(0.5) ? static_disc({}, random.uniform(0.1, 1))
                                           : fixed(turned(box({}, random.uniform(0.1, 2), 0.3), random.uniform(0, 3)));
      body.position = at;
      s.population.add(body, error);
    }
    s.bodies.keep_rotation(true);
    const kernels::ReachParams margin{.skin = 0.05f, .time = 0.02f};
    s.make_lists(margin);
    s.go_to_the_limit(random, margin);
    std::vector<std::uint32_t> near;
    const Hull* const parts = &s.bodies.hulls[s.bodies.kind(s.bodies.id[wide]).first_hull];
    const Rotor turn = rotor_of(s.bodies.angle[wide]);
    for (std::uint32_t shape = 0; shape < s.population.statics.size(); ++shape) {
      near.clear();
      s.search.near_piece({wide, shape, 0}, {}, near);
      const Hull piece = s.population.statics.seen_from(shape, s.bodies.point(wide), 1000);
      for (std::uint32_t k = 0; k < s.parts(wide); ++k) {
        if (nearest(piece, Rotor{}, parts[k], turn, 0, 0).distance > 0) continue;
        ++touching;
        ASSERT_TRUE(std::ranges::binary_search(near, k)) << "seed " << seed << ", shape " << shape << ", part " << k;
      }
    }
    const Walls walls{s.lattice.to_lattice({-8, -8}), s.lattice.to_lattice({8, 8})};
    for (const std::uint32_t wall : {kWallLeft, kWallRight, kWallBottom, kWallTop}) {
      near.clear();
      s.search.near_piece({wide, wall, 0}, walls, near);
      const auto [nx, ny, height] = walls.face(wall, s.bodies.point(wide), s.lattice);
      for (std::uint32_t k = 0; k < s.parts(wide); ++k) {
        const Manifold m = meet_plane(parts[k], turn, nx, ny, static_cast<float>(height), 0);
        EXPECT_TRUE(m.count == 0 || std::ranges::binary_search(near, k)) << "seed " << seed << ", wall " << wall;
      }
    }
  }
  EXPECT_GT(touching, 300u);
}

}  // namespace
}  // namespace psim::test
