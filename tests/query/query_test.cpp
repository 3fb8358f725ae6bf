// Questions to worlds of every shape, against brute force.
#include "body_outlines.h"
#include "sanitized.h"
#include "support.h"

namespace psim::test {
namespace {

struct Place {
  const char* name;
  Boundary boundary;
  Vec2 offset;  // of the bounds
  double side;  // m

  friend void PrintTo(const Place& p, std::ostream* out) { *out << p.name; }
};

const Place kPlaces[] = {{"Walls", Boundary::walls, {-20, -20}, 40},
                         {"Open", Boundary::open, {5, -300}, 40},
                         {"Periodic", Boundary::periodic, {-7, 3}, 40},
                         {"FarAway", Boundary::open, {3e6, -7e6}, 40},
                         {"Large", Boundary::walls, {-5e4, -2e4}, 1e5}};

Shape random_shape(Random& r, double size, bool chains) {
  const auto point = [&] { return Vec2{r.uniform(-size, size), r.uniform(-size, size)}; };
  switch (r.below(chains ? 6 : 5)) {
    case 0:
      return DiscShape{r.uniform(0.2, 1) * size};
    case 1:
      return SegmentShape{point(), point()};
    case 2:
      return BoxShape{r.uniform(0.3, 2) * size, r.uniform(0.3, 2) * size, r.chance(0.5) ? 0.2 * size : 0};
    case 3:
      return CapsuleShape{point(), point(), r.uniform(0.1, 0.5) * size};
    case 4: {
      PolygonShape polygon;
      const std::size_t n = 3 + r.below(6);
      const Vec2 off = point();
      for (std::size_t k = 0; k < n; ++k) {
        const double a = 2 * kPi * (static_cast<double>(k) + r.uniform(-0.1, 0.1)) / static_cast<double>(n);
        polygon.vertices.push_back({off.x + size * std::cos(a), off.y + size * std::sin(a)});
      }
      if (r.chance(0.5)) polygon.radius = 0.2 * size;
      return polygon;
    }
    default: {
      ChainShape chain;
      double x = -size;
      for (std::size_t k = 0; k < 5; ++k, x += 0.5 * size) {
        chain.vertices.push_back({x, r.uniform(-0.5, 0.5) * size});
      }
      chain.loop = r.chance(0.3);
      return chain;
    }
  }
}

/// A world and what was put into it.
struct Zoo {
  std::unique_ptr<World> world;
  std::vector<BodyDesc> desc;
  std::vector<BodyId> id;
  std::vector<Vec2> shifts;  // of images
  Place place;

  explicit Zoo(const Place& p, std::uint64_t seed, std::size_t bodies = 150, int threads = 1) : place(p) {
    Random r(seed);
    WorldDesc d;
    d.bounds = {p.offset.x, p.offset.y, p.offset.x + p.side, p.offset.y + p.side};
    d.boundary = p.boundary;
    d.gravity = {0, 0};
    world = make(d, best_isa(), threads);
    for (std::size_t k = 0; k < bodies; ++k) {
      BodyDesc body;
      body.type = r.chance(0.3)   ? BodyType::static_body
                  : r.chance(0.2) ? BodyType::kinematic_body
                                  : BodyType::dynamic_body;
      const double size = std::pow(20, r.uniform(-1, 0.4)) * p.side / 40;
      body.shape = random_shape(r, size, body.type != BodyType::dynamic_body);
      body.position = {r.uniform(d.bounds.xmin, d.bounds.xmax), r.uniform(d.bounds.ymin, d.bounds.ymax)};
      body.angle = r.uniform(-4, 4);
      body.velocity = {r.uniform(-1, 1), r.uniform(-1, 1)};
      body.angular_velocity = r.uniform(-1, 1);
      body.filter.category = 1u << r.below(3);
      body.sensor = body.type != BodyType::dynamic_body && r.chance(0.2);
      desc.push_back(body);
      id.push_back(add(*world, body));
    }
    run(*world, 2);
    world->set_velocity(id[3], {kNan, 0}, 0);  // frozen, if it moves
    run(*world, 1);
    for (std::size_t k = 10; k < 20; ++k) world->remove_body(id[k]);
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        if (p.boundary == Boundary::periodic || (x == 0 && y == 0)) {
          shifts.push_back({x * p.side, y * p.side});
        }
      }
    }
  }

  bool wanted(std::size_t k, const QueryFilter& f) const {
    const BodyDesc& d = desc[k];
    if (!world->is_valid(id[k]) || (d.sensor && !f.sensors)) return false;
    if ((d.filter.category & f.mask) == 0) return false;
    return d.type == BodyType::dynamic_body ? f.dynamic : d.type == BodyType::kinematic_body ? f.kinematic : f.fixed;
  }

  /// measure(outline) over all images of all parts: the least.
  template <class Measure>
  double least(std::size_t k, const Measure& measure) const {
    const BodyState s = state(*world, id[k]);
    double best = 1e300;
    for (const Vec2 shift : shifts) {
      for (const reference::Outline& o : outlines(desc[k].shape, {s.x + shift.x, s.y + shift.y}, s.angle)) {
        best = std::min(best, measure(o));
      }
    }
    return best;
  }

  Vec2 somewhere(Random& r) const {
    return {place.offset.x + r.uniform(0, place.side), place.offset.y + r.uniform(0, place.side)};
  }
};

QueryFilter random_filter(Random& r) {
  QueryFilter f;
  if (r.chance(0.5)) return f;
  f.mask = static_cast<std::uint32_t>(r.below(8));
  f.dynamic = r.chance(0.7);
  f.kinematic = r.chance(0.7);
  f.fixed = r.chance(0.7);
  f.sensors = r.chance(0.5);
  return f;
}

class Query : public testing::TestWithParam<Place> {
 protected:
  // Lengths that may differ: the engine has its bodies in floats.
  double fuzz() const { return 1e-5 * GetParam().side / 40; }
};

TEST_P(Query, RaysMeetWhatBruteForceMeets) {
  std::size_t hits = 0, starts_inside = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Zoo zoo(GetParam(), seed);
    Random r(seed + 100);
    for (int n = 0; n < 100; ++n) {
      const Vec2 p = zoo.somewhere(r), q = zoo.somewhere(r);
      const QueryFilter filter = random_filter(r);
      const double way = std::hypot(q.x - p.x, q.y - p.y);
      const std::vector<RayHit> all = zoo.world->ray_cast_all(p, q, filter);
      for (std::size_t k = 0; k + 1 < all.size(); ++k) {
        EXPECT_TRUE(all[k].fraction < all[k + 1].fraction ||
                    (all[k].fraction == all[k + 1].fraction && all[k].body.index < all[k + 1].body.index));
      }
      const auto first = zoo.world->ray_cast(p, q, filter);
      ASSERT_EQ(first.has_value(), !all.empty());
      if (first) {
        EXPECT_EQ(first->body, all[0].body);
        EXPECT_EQ(first->fraction, all[0].fraction);
        EXPECT_EQ(first->normal.x, all[0].normal.x);
        EXPECT_EQ(first->normal.y, all[0].normal.y);
      }
      for (std::size_t k = 0; k < zoo.id.size(); ++k) {
        const auto hit = std::find_if(all.begin(), all.end(), [&](const RayHit& h) { return h.body == zoo.id[k]; });
        if (!zoo.wanted(k, filter)) {
          EXPECT_EQ(hit, all.end()) << "body " << k;
          continue;
        }
        double nearest = 1e300;
        const double fraction = zoo.least(k, [&](const reference::Outline& o) {
          double mine = 0;
          const double f = reference::march(o, exact(p), exact(q), mine);
          nearest = std::min(nearest, mine);
          return f;
        });
        if (hit == all.end()) {
          if (fraction > 1) continue;
          // A ray that only just touches may be held for either: moved aside a little, one misses.
          bool grazes = false;
          for (const double side : {-fuzz(), fuzz()}) {
            const Vec2 u{(q.x - p.x) / way, (q.y - p.y) / way}, off{-side * u.y, side * u.x};
            const Vec2 from{p.x + off.x, p.y + off.y};
            const Vec2 to{q.x + off.x - fuzz() * u.x, q.y + off.y - fuzz() * u.y};
            grazes |= zoo.least(k, [&](const reference::Outline& o) {
              double mine = 0;
              return reference::march(o, exact(from), exact(to), mine);
            }) > 1;
          }
          EXPECT_TRUE(grazes) << "body " << k << " missed at " << fraction;
          continue;
        }
        EXPECT_LT(nearest, fuzz()) << "body " << k;
        ++hits;
        const Vec2 at{p.x + hit->fraction * (q.x - p.x), p.y + hit->fraction * (q.y - p.y)};
        EXPECT_NEAR(hit->point.x, at.x, fuzz());
        EXPECT_NEAR(hit->point.y, at.y, fuzz());
        const auto off = [&](Vec2 point) {
          return zoo.least(k, [&](const reference::Outline& o) { return distance(o, exact(point)); });
        };
        EXPECT_NEAR(off(at), 0, fuzz()) << "body " << k;
        if (hit->fraction == 0) {
          ++starts_inside;
          EXPECT_LT(off(p), fuzz());
          EXPECT_EQ(hit->normal.x, 0);
          EXPECT_EQ(hit->normal.y, 0);
          continue;
        }
        EXPECT_NEAR(std::hypot(hit->normal.x, hit->normal.y), 1, 1e-6);
        EXPECT_LE(hit->normal.x * (q.x - p.x) + hit->normal.y * (q.y - p.y), 1e-6 * way);
        // Nothing of the body before that point, unless the ray grazes it.
        if (fraction <= 1 && hit->fraction - fraction > fuzz() / way) {
          const Vec2 before{p.x + (fraction + hit->fraction) / 2 * (q.x - p.x),
                            p.y + (fraction + hit->fraction) / 2 * (q.y - p.y)};
          EXPECT_LT(off(before), fuzz());
          EXPECT_LT((hit->fraction - fraction) * way, 0.02 * GetParam().side) << "body " << k;
        }
        // The normal points to where the distance grows by as much.
        const double step = 10 * fuzz();
        const double grown = off({at.x + step * hit->normal.x, at.y + step * hit->normal.y});
        if (GetParam().boundary != Boundary::periodic) {
          EXPECT_LE(grown, step + 2 * fuzz());
        }
      }
    }
  }
  EXPECT_GT(hits, 250u);
  EXPECT_GT(starts_inside, 10u);
}

TEST_P(Query, NearestIsNearest) {
  std::size_t found = 0, inside = 0, none = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Zoo zoo(GetParam(), seed, seed == 4 ? 25 : 150);
    Random r(seed + 200);
    for (int n = 0; n < 100; ++n) {
      const Vec2 p = zoo.somewhere(r);
      const double reach = std::pow(300, r.uniform(-1, 0)) * GetParam().side;
      const QueryFilter filter = random_filter(r);
      double least = 1e300;
      for (std::size_t k = 0; k < zoo.id.size(); ++k) {
        if (!zoo.wanted(k, filter)) continue;
        least = std::min(least, zoo.least(k, [&](const auto& o) { return distance(o, exact(p)); }));
      }
      const auto hit = zoo.world->closest(p, reach, filter);
      if (!hit) {
        ++none;
        EXPECT_GT(least, reach - fuzz());
        continue;
      }
      ++found;
      EXPECT_NEAR(hit->distance, least, fuzz());
      EXPECT_NEAR(std::hypot(hit->point.x - p.x, hit->point.y - p.y), hit->distance, fuzz());
      const auto which = std::find(zoo.id.begin(), zoo.id.end(), hit->body);
      ASSERT_NE(which, zoo.id.end());
      const auto k = static_cast<std::size_t>(which - zoo.id.begin());
      EXPECT_TRUE(zoo.wanted(k, filter));
      EXPECT_NEAR(zoo.least(k, [&](const auto& o) { return distance(o, exact(hit->point)); }), 0, fuzz());
      if (hit->distance > 0) continue;
      ++inside;
      for (std::size_t other = 0; other < k; ++other) {  // of several the least id
        if (!zoo.wanted(other, filter)) continue;
        const double around = zoo.least(other, [&](const auto& o) {
          double most = 0;
          for (const double dx : {-fuzz(), fuzz()}) {
            for (const double dy : {-fuzz(), fuzz()}) {
              most = std::max(most, distance(o, {p.x + dx, p.y + dy}));
            }
          }
          return most;
        });
        EXPECT_GT(around, 0) << "body " << other;
      }
    }
  }
  EXPECT_GT(found, 100u);
  EXPECT_GT(inside, 10u);
  EXPECT_GT(none, 1u);
}

TEST_P(Query, OverlapsAndRegionsAreComplete) {
  std::size_t yes = 0, no = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Zoo zoo(GetParam(), seed);
    Random r(seed + 300);
    for (int n = 0; n < 100; ++n) {
      const Vec2 p = zoo.somewhere(r);
      const QueryFilter filter = random_filter(r);
      const double angle = r.uniform(-4, 4), size = GetParam().side * r.uniform(0.01, 0.2);
      Shape shape = random_shape(r, size, true);
      std::vector<BodyId> found;
      std::vector<reference::Outline> mine;
      if (n % 2 == 0) {
        found = zoo.world->overlap(shape, p, angle, filter);
        mine = outlines(shape, p, angle);
      } else {
        const double w = size, h = size * r.uniform(0, 2);
        found = zoo.world->in_region({p.x - w, p.y - h, p.x + w, p.y + h}, filter);
        mine = outlines(BoxShape{2 * w, 2 * h, 0}, p, 0);
      }
      for (std::size_t k = 0; k + 1 < found.size(); ++k) {
        EXPECT_LT(found[k].index, found[k + 1].index);
      }
      for (std::size_t k = 0; k < zoo.id.size(); ++k) {
        const bool in = std::find(found.begin(), found.end(), zoo.id[k]) != found.end();
        if (!zoo.wanted(k, filter)) {
          EXPECT_FALSE(in) << "body " << k;
          continue;
        }
        const double apart = zoo.least(k, [&](const reference::Outline& o) {
          double best = 1e300;
          for (const reference::Outline& part : mine) best = std::min(best, distance(o, part));
          return best;
        });
        (in ? yes : no) += 1;
        if (in) {
          EXPECT_LT(apart, fuzz()) << "body " << k;
        } else if (apart == 0) {  // unless they only just touch
          const double deeper = zoo.least(k, [&](const reference::Outline& o) {
            double best = 1e300;
            for (reference::Outline part : mine) {
              for (const double dx : {-1.0, 1.0}) {
                for (const double dy : {-1.0, 1.0}) {
                  reference::Outline moved = part;
                  for (reference::Vec& v : moved.points) v.x += dx * fuzz(), v.y += dy * fuzz();
                  best = std::max(best == 1e300 ? 0 : best, distance(o, moved));
                }
              }
            }
            return best;
          });
          EXPECT_GT(deeper, 0) << "body " << k;
        }
      }
    }
  }
  EXPECT_GT(yes, 500u);
  EXPECT_GT(no, 500u);
}

INSTANTIATE_TEST_SUITE_P(Places, Query, testing::ValuesIn(kPlaces),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace psim::test
