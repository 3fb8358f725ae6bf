// L11, L12 and L16: what time does, to errors, to what stands, and to what turns.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "course.h"
#include "law.h"
#include "scenes.h"
#include "shapes.h"

namespace psim::laws {
namespace {

void add(Scene& scene, const BodyDesc& body) {
  scene.bodies.push_back(body);
  scene.body_names.emplace_back();
}

// ---- L11: more substeps -----------------------------------------------------------------------------

// The error of a scene at some substeps is its distance from the same scene at 64.
double error_at(const Scene& scene, const Course& truth, int substeps, int& worst_frame) {
  Scene other = scene;
  other.world.substeps = substeps;
  const Course course = course_of(other, static_cast<int>(truth.size()) - 1);
  double most = 0;
  for (std::size_t frame = 0; frame < truth.size(); ++frame) {
    for (std::size_t id = 0; id < scene.bodies.size(); ++id) {
      const double off = std::hypot(course[frame][id].x - truth[frame][id].x, course[frame][id].y - truth[frame][id].y);
      if (off > most) most = off, worst_frame = static_cast<int>(frame);
    }
  }
  return most;
}

std::optional<Fault> more_substeps(const Scene& scene) {
  constexpr int kFrames = 60;
  Scene finest = scene;
  finest.world.substeps = 64;
  const Course truth = course_of(finest, kFrames);
  int frame = 0;
  const double coarse = error_at(scene, truth, 4, frame), fine = error_at(scene, truth, 16, frame);
  const double rounding = 1e-5 * size_of(scene, kFrames);
  if (fine <= 1.05 * coarse + rounding) return std::nullopt;
  return Fault{frame, fmt::format("16 substeps err by {:.3g} m, 4 by {:.3g}", fine, coarse)};
}

// ---- L12: what stands ---------------------------------------------------------------------------------

Material rough() { return {1, 0, 0.6}; }

void add_tower(Draw& draw, Scene& scene, double x) {
  double y = 0;
  double wide = draw.uniform(0.8, 1.5);
  for (int k = draw.from(1, 12); k > 0; --k) {
    const double high = draw.uniform(0.4, 1.2);
    BodyDesc box = body_of(BoxShape{wide, high, 0}, {x + 0.05 * wide * draw.uniform(-1, 1), y + high / 2}, rough());
    box.material.density = draw.logarithmic(0.5, 2);
    add(scene, box);
    y += high;
    wide *= draw.uniform(0.9, 1);
  }
}

void add_pyramid(Draw& draw, Scene& scene, double x) {
  const int rows = draw.from(2, 7);
  for (int row = 0; row < rows; ++row) {
    for (int k = 0; k < rows - row; ++k) {
      add(scene, body_of(BoxShape{1, 1, 0}, {x + 1.1 * (k - (rows - row - 1) / 2.0), row + 0.5}, rough()));
    }
  }
}

// A plank on two posts, and a box on it.
void add_table(Draw& draw, Scene& scene, double x) {
  const double high = draw.uniform(0.5, 2), wide = draw.uniform(2, 4);
  for (const double side : {-0.4, 0.4})
    add(scene, body_of(BoxShape{0.4, high, 0}, {x + side * wide, high / 2}, rough()));
  add(scene, body_of(BoxShape{wide, 0.2, 0}, {x, high + 0.1}, rough()));
  if (draw.chance(0.5))
    add(scene, body_of(BoxShape{0.5, 0.5, 0}, {x + draw.uniform(-0.2, 0.2) * wide, high + 0.45}, rough()));
}

// Two cards that lean on each other at up to 22 degrees from upright; friction 0.6 holds up to 50.
void add_cards(Draw& draw, Scene& scene, double x) {
  const double lean = draw.uniform(0.1, 0.38), high = 2, thick = 0.1;
  for (const double side : {-1.0, 1.0}) {
    const double c = std::cos(lean), s = std::sin(lean);
    // The lower outer corner stands on the ground, the upper inner corners touch.
    BodyDesc card = body_of(BoxShape{thick, high, 0},
                            {x + side * (high * s / 2 + thick * c / 2), high * c / 2 + thick * s / 2}, rough());
    card.angle = side * lean;
    add(scene, card);
  }
}

Scene standing(Draw& draw) {
  Scene scene = space(true);
  scene.world.sleeping = true;
  if (draw.chance(0.5)) {
    add(scene, fixed_of(SegmentShape{{-50, 0}, {50, 0}}, {}, rough()));
  } else {
    add(scene, fixed_of(BoxShape{100, 2, 0}, {0, -1}, rough()));
  }
  for (double x = -12; x <= 12; x += 12) {
    switch (draw.below(4)) {
      case 0:
        add_tower(draw, scene, x);
        break;
      case 1:
        add_pyramid(draw, scene, x);
        break;
      case 2:
        add_table(draw, scene, x);
        break;
      default:
        add_cards(draw, scene, x);
    }
    if (draw.chance(0.5)) break;
  }
  return scene;
}

std::optional<Fault> stands(const Scene& scene) {
  constexpr int kFrames = 300;
  std::optional<Fault> fault;
  const auto look = [&](World& world, int frame) {
    for (std::uint32_t id = 1; id < scene.bodies.size(); ++id) {
      const auto b = world.body(world.id_of(id));
      const Vec2 from = scene.bodies[id].position;
      const double moved = b ? std::hypot(b->x - from.x, b->y - from.y) : 1e300;
      if (moved > 0.02) {
        fault = Fault{frame, fmt::format("body {} of what should stand moved by {:.3g} m", id, moved)};
        return false;
      }
      if (frame == kFrames && world.is_awake(world.id_of(id))) {
        fault = Fault{frame, fmt::format("body {} is awake after 5 s: {}", id, world.why_awake(world.id_of(id)))};
        return false;
      }
    }
    return true;
  };
  course_of(scene, kFrames, look);
  return fault;
}

// ---- L16: a turning arm ---------------------------------------------------------------------------------

// A bead before an arm that turns about the origin: without friction it goes outwards, s = s0 cosh(omega t).
Scene bead_on_an_arm(Draw& draw) {
  Scene scene = space(false);
  const double omega = draw.logarithmic(0.5, 10), r = draw.uniform(0.1, 0.3), s0 = draw.uniform(0.5, 2);
  const double side = draw.sign(), half = 0.1;
  BodyDesc arm = fixed_of(BoxShape{80, 2 * half, 0}, {}, {1, 0, 0});
  arm.type = BodyType::kinematic_body;
  arm.angular_velocity = side * omega;
  const double d = side * (half + r);
  BodyDesc bead =
      body_of(draw.chance(0.6) ? Shape(DiscShape{r}) : Shape(BoxShape{2 * r, 2 * r, 0}), {s0, d}, {1, 0, 0});
  bead.velocity = {-side * omega * d, side * omega * s0};
  bead.angular_velocity = std::holds_alternative<DiscShape>(bead.shape) ? 0 : side * omega;
  add(scene, bead);
  add(scene, arm);
  return scene;
}

std::optional<Fault> carried(const Scene& scene) {
  const double omega = std::fabs(scene.bodies[1].angular_velocity), s0 = scene.bodies[0].position.x;
  const double arm = std::get<BoxShape>(scene.bodies[1].shape).width / 2;
  const double far = std::fabs(scene.bodies[0].position.y);
  std::optional<Fault> fault;
  const auto look = [&](World& world, int frame) {
    const auto b = world.body(world.id_of(0));
    const double exact = s0 * std::cosh(omega * frame * scene.world.dt);
    if (!b || exact > 0.8 * arm) return false;
    const double is = std::sqrt(std::max(0.0, b->x * b->x + b->y * b->y - far * far));
    const double turn = omega * scene.world.dt / scene.world.substeps;
    const double allowed = (0.01 + turn * turn) * exact;
    if (std::fabs(is - exact) <= allowed) return true;
    fault = Fault{frame, fmt::format("the bead is {:.4g} m out on the arm, closed form {:.4g}", is, exact)};
    return false;
  };
  course_of(scene, 300, look);
  return fault;
}

}  // namespace

std::vector<Law> time_laws() {
  return {{"L11", "more substeps are not worse", Spare::all, one_mover, more_substeps},
          {"L12", "what stands, stands, and sleeps within 5 s", Spare::nothing, standing, stands},
          {"L16", "part of a turn: a turning arm carries what lies on it", Spare::nothing, bead_on_an_arm, carried}};
}

}  // namespace psim::laws
