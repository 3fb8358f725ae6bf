// Scenes for JavaScript: built-in ones and those of JSON texts, the worlds made of them, and what bodies look like.
#include <cstring>
#include <new>
#include <string>
#include <variant>
#include <vector>

#include "bodies/hull.h"
#include "flat.h"
#include "handle.h"
#include "place/links.h"
#include "place/shape_size.h"
#include "psim/scene.h"

/// A scene and the text that was asked of it last.
struct psim_flat_scene {
  psim::Scene scene;
  std::string text;
  std::vector<std::uint32_t> shape_of;
  std::vector<double> shapes;
};

namespace {

using psim::web::error;

/// Runs make() and keeps the line of what went wrong; null then.
template <class Make>
auto kept(const Make& make) noexcept -> decltype(make()) {
  try {
    return make();
  } catch (const std::bad_alloc&) {
    psim::capi::copy_text("out of memory", error, sizeof error);
  } catch (const std::exception& e) {
    psim::capi::copy_text(e.what(), error, sizeof error);
  }
  return nullptr;
}

psim_flat_scene* give(std::optional<psim::Scene> scene, const std::string& wrong) {
  psim::capi::copy_text(wrong, error, sizeof error);
  return scene ? new psim_flat_scene{std::move(*scene), {}, {}, {}} : nullptr;
}

// kind (0 disc, 1 area, 2 line, 3 closed line, 4 several parts), radius, mass of a body, number of points, their x and y.
// Of several parts the number is that of the parts, and each follows in this form without a mass.
void append_shape(const psim::BodyDesc& body, std::vector<double>& shapes) {
  psim::HullSet hulls;
  std::string wrong;
  const bool whole = psim::make_hulls(body.shape, true, hulls, wrong, body.material.density);
  const double mass = body.mass > 0 ? body.mass : whole ? body.material.density * hulls.mass.area : 0;
  const auto append = [&](const psim::Outline& outline, bool disc) {
    const std::size_t points = disc ? 0 : outline.points.size();
    const double kind = disc ? 0.0 : !outline.line ? 1.0 : outline.closed ? 3.0 : 2.0;
    shapes.insert(shapes.end(), {kind, outline.radius, mass, static_cast<double>(points)});
    for (std::size_t k = 0; k < points; ++k) shapes.insert(shapes.end(), {outline.points[k].x, outline.points[k].y});
  };
  const std::vector<psim::Outline> all = psim::outlines(body.shape);
  if (!std::holds_alternative<psim::CompoundShape>(body.shape)) return append(all.front(), psim::is_disc(body.shape));
  shapes.insert(shapes.end(), {4.0, 0.0, mass, static_cast<double>(all.size())});
  for (const psim::Outline& outline : all) append(outline, false);
}

}  // namespace

PSIM_FLAT const char* psim_flat_error() { return error; }

PSIM_FLAT const char* psim_flat_builtin_name(int k) {
  const auto& all = psim::builtin_scenes();
  return k >= 0 && k < static_cast<int>(all.size()) ? all[static_cast<std::size_t>(k)].name.data() : nullptr;
}
PSIM_FLAT const char* psim_flat_builtin_words(int k) {
  return psim::builtin_scenes()[static_cast<std::size_t>(k)].description.data();
}
/// The default number of bodies; negative where it cannot be chosen.
PSIM_FLAT double psim_flat_builtin_count(int k) {
  const auto& scene = psim::builtin_scenes()[static_cast<std::size_t>(k)];
  const auto count = static_cast<double>(scene.default_particles);
  return scene.sized ? count : -count;
}

PSIM_FLAT psim_flat_scene* psim_flat_builtin(const char* name, double bodies, double seed) {
  return kept([&] {
    std::string wrong;
    auto scene = psim::make_builtin(name, static_cast<std::uint64_t>(bodies), static_cast<std::uint64_t>(seed), wrong);
    return give(std::move(scene), wrong);
  });
}
PSIM_FLAT psim_flat_scene* psim_flat_parse(const char* text, const char* file) {
  return kept([&] {
    std::string wrong;
    auto scene = psim::parse_scene(text, file, wrong);
    return give(std::move(scene), wrong);
  });
}
PSIM_FLAT void psim_flat_scene_free(psim_flat_scene* scene) { delete scene; }

PSIM_FLAT const char* psim_flat_scene_json(psim_flat_scene* scene) {
  return kept([&] { return (scene->text = psim::scene_to_json(scene->scene)).c_str(); });
}
PSIM_FLAT void psim_flat_scene_substeps(psim_flat_scene* scene, int substeps) {
  scene->scene.world.substeps = substeps;
}

PSIM_FLAT psim_world* psim_flat_scene_world(const psim_flat_scene* scene, int isa) {
  psim_world* world = nullptr;
  psim::capi::make_handle("psim_flat_scene_world", &world, error, sizeof error, [&](const psim::capi::Call& call) {
    const psim::RunOptions options{isa < 0 ? psim::best_isa() : static_cast<psim::Isa>(isa), 1};
    std::string wrong;
    call.world->world = psim::build_world(scene->scene, options, wrong);
    return call.world->world ? static_cast<psim_result>(PSIM_OK) : call.fail(PSIM_ERROR_ARGUMENT, wrong);
  });
  psim::web::share_workers(world);
  return world;
}

/// Adds the bodies of a scene to a world that is there already: how many, or -1. Its groups and joints are left out.
PSIM_FLAT int psim_flat_scene_add_bodies(const psim_flat_scene* scene, psim_world* world, psim_body_id* ids) {
  int added = 0;
  const psim_result result =
      psim::capi::guarded(world, "add", [&](psim::World&, const psim::capi::Call& call) -> psim_result {
        for (const psim::BodyDesc& body : scene->scene.bodies) {
          std::string wrong;
          const psim::BodyId id = world->changed([&](auto& one) { return one.add_body(body, wrong); });
          if (id == psim::kNoBody) return call.fail(PSIM_ERROR_ARGUMENT, wrong);
          ids[added++] = {id.index, id.generation};
        }
        return PSIM_OK;
      });
  return result == PSIM_OK ? added : -1;
}

/// For every body the number of its shape, which is where it begins in the second array.
PSIM_FLAT const std::uint32_t* psim_flat_scene_shape_of(psim_flat_scene* scene) {
  return kept([&]() -> const std::uint32_t* {
    const psim::SceneBodies bodies(scene->scene);
    const psim::BodyDesc* before = nullptr;
    scene->shape_of.clear(), scene->shapes.clear();
    for (std::uint64_t id = 0, count = scene->scene.body_count(), first = 0; id < count; ++id) {
      const psim::BodyDesc& body = bodies.desc_of(id);
      if (&body != before) first = scene->shapes.size(), append_shape(body, scene->shapes);
      before = &body;
      scene->shape_of.push_back(static_cast<std::uint32_t>(first));
    }
    return scene->shape_of.data();
  });
}
PSIM_FLAT const double* psim_flat_scene_shapes(const psim_flat_scene* scene) { return scene->shapes.data(); }
PSIM_FLAT int psim_flat_scene_shape_numbers(const psim_flat_scene* scene) {
  return static_cast<int>(scene->shapes.size());
}
/// The number of fluids; the first one has number 0.
PSIM_FLAT int psim_flat_scene_fluids(const psim_flat_scene* scene) {
  return static_cast<int>(scene->scene.fluids.size());
}
/// out: spacing, density, viscosity, surface tension.
PSIM_FLAT void psim_flat_scene_fluid(const psim_flat_scene* scene, int k, double* out) {
  const psim::FluidDesc& fluid = scene->scene.fluids[static_cast<std::size_t>(k)].fluid;
  out[0] = fluid.spacing, out[1] = fluid.density, out[2] = fluid.viscosity, out[3] = fluid.surface_tension;
}
PSIM_FLAT int psim_flat_scene_bodies(const psim_flat_scene* scene) {
  return static_cast<int>(scene->scene.body_count());
}
