// Fluids of a picture: each as an area with a smooth outline (fluid_field.h), or as its particles.
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "picture/painter.h"
#include "surface/fluid_field.h"

namespace psim::cli {
// What is drawn of a fluid.
struct Painter::OneFluid {
  FluidId number;
  double spacing;
  std::vector<Vec2> places;
  std::vector<float> values;  // shares of the brightest; empty: the fluid's colour

  Colour colour_of(std::size_t k) const {
    return values.empty() ? from_srgb(fluid_rgb(number)) : ramp(static_cast<double>(values[k]));
  }
};

void Painter::paint_fluids(Canvas& canvas, const PictureCamera& camera, const Moment& moment,
                           const Brightest& bright) const {
  if (moment.particles.empty()) return;
  std::vector<OneFluid> fluids;
  for (const SceneFluid& fluid : scene_.fluids) {
    fluids.push_back({static_cast<FluidId>(fluids.size()), fluid.fluid.spacing, {}, {}});
  }
  for (const FluidParticleState& p : moment.particles) {
    if (p.fluid >= fluids.size() || !std::isfinite(p.position.x + p.position.y)) continue;
    OneFluid& fluid = fluids[p.fluid];
    fluid.places.push_back(p.position);
    if (fluid_colouring_ == FluidColouring::speed) {
      fluid.values.push_back(static_cast<float>(std::hypot(p.velocity.x, p.velocity.y) / bright.fluid_speed));
    } else if (fluid_colouring_ == FluidColouring::pressure) {
      fluid.values.push_back(static_cast<float>(p.pressure / bright.pressure));
    }
  }
  for (const OneFluid& fluid : fluids) {
    if (fluid_style_ == FluidStyle::surface) {
      paint_surface(canvas, camera, fluid);
    } else {
      paint_particles(canvas, camera, fluid);
    }
  }
}

void Painter::paint_surface(Canvas& canvas, const PictureCamera& camera, const OneFluid& fluid) const {
  const Bounds& world = scene_.world.bounds;
  FluidField field;
  make_fluid_field(fluid.places, fluid.values,
                   {fluid.spacing, 1 / camera.length(1), camera.shown(canvas.width(), canvas.height()), world,
                    scene_.world.boundary},
                   field);
  for (const std::uint32_t k : field.lone) {
    constexpr double kSameArea = 0.5641895835477563;  // radius of a disc of one spacing squared
    const Point at = camera.at(fluid.places[k]);
    canvas.disc(at.x, at.y, camera.length(kSameArea * fluid.spacing), fluid.colour_of(k));
  }
  if (field.is_empty()) return;
  FieldArea area;
  area.corner = camera.at(field.origin);
  area.cell = camera.length(field.cell);
  area.columns = field.columns;
  area.rows = field.rows;
  area.edge = kFluidEdge;
  area.numbers = std::move(field.fullness);
  for (const float value : field.value) area.colours.push_back(ramp(static_cast<double>(value)));
  area.low = camera.at({world.xmin, world.ymax});
  area.high = camera.at({world.xmax, world.ymin});
  canvas.field(std::move(area), fluid.colour_of(0));
}

void Painter::paint_particles(Canvas& canvas, const PictureCamera& camera, const OneFluid& fluid) const {
  const Bounds& w = scene_.world.bounds;
  const double radius = fluid.spacing / 2;
  const bool wraps = scene_.world.boundary == Boundary::periodic;
  // The way to the other side of a periodic world for a disc that reaches over a side, else 0.
  const auto over = [&](double at, double low, double high) {
    if (!wraps) return 0.0;
    return at - radius < low ? high - low : at + radius > high ? low - high : 0.0;
  };
  for (std::size_t k = 0; k < fluid.places.size(); ++k) {
    const Vec2 place = fluid.places[k];
    const Vec2 other{over(place.x, w.xmin, w.xmax), over(place.y, w.ymin, w.ymax)};
    const auto draw = [&](Vec2 at) {
      const Point pixel = camera.at(at);
      canvas.disc(pixel.x, pixel.y, camera.length(radius), fluid.colour_of(k));
    };
    draw(place);
    if (other.x != 0) draw({place.x + other.x, place.y});
    if (other.y != 0) draw({place.x, place.y + other.y});
    if (other.x != 0 && other.y != 0) draw({place.x + other.x, place.y + other.y});
  }
}

}  // namespace psim::cli
