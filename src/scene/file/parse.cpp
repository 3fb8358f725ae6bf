// Scene files: text in, Scene or a one-line error out. What the format is: docs/scenes.md.
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <string_view>

#include "base/os.h"
#include "file/parse_parts.h"
#include "file/rube.h"

namespace psim {
namespace {

constexpr std::array<std::string_view, 13> kSceneKeys = {"psim",      "name",     "description", "world",  "step",
                                                         "materials", "bodies",   "groups",      "joints", "fields",
                                                         "fluids",    "emitters", "drains"};
constexpr std::uint64_t kFormat = 1;

Scene read_scene(const scene::Json& document) {
  const scene::Node root(document);
  root.expect_object();
  if (scene::is_rube(root)) return scene::read_rube(root);
  // First of all: a file of another format has other keys.
  const scene::Node format = root.require("psim");
  if (!(format.is_number() && format.json() == kFormat)) {
    format.fail("is not a format that this version reads: 1");
  }
  root.expect_object(kSceneKeys);

  Scene out;
  scene::Context context;
  if (const auto name = root.find("name")) out.name = name->name();
  if (const auto description = root.find("description")) out.description = description->string();
  scene::read_materials(root, context);
  scene::read_world(root, context, out.world);
  scene::read_step(root, out);
  scene::read_fields(root, out.world);
  scene::read_bodies(root, context, out);
  scene::read_groups(root, context, out);
  scene::read_joints(root, context, out);
  scene::read_fluids(root, context, out);
  scene::read_emitters(root, context, out);
  scene::read_drains(root, out);
  return out;
}

std::string error_line(std::string_view text, std::string_view file, const scene::SceneError& error) {
  const std::size_t offset =
      error.offset != scene::SceneError::kLookUp ? error.offset : scene::offset_of(text, error.path, error.at);
  const scene::TextPosition position = scene::position_of(text, offset);
  return scene::printable(file, 4096) + ':' + std::to_string(position.line) + ':' + std::to_string(position.column) +
         ": " + scene::path_text(error.path) + ": " + error.message;
}

// False, with errno set, if the file cannot be read.
bool read_file(const std::string& path, std::size_t most, std::string& text) {
  const os::FileToRead file = os::open_to_read(path);
  if (!file) return false;
  constexpr std::size_t kChunk = std::size_t{1} << 16;
  for (std::size_t used = 0;;) {
    text.resize(used + kChunk);
    const std::size_t got = std::fread(text.data() + used, 1, kChunk, file.get());
    used += got;
    if (got < kChunk || used > most) {
      text.resize(used);
      return std::ferror(file.get()) == 0;
    }
  }
}

}  // namespace

std::uint64_t Scene::body_count() const {
  std::uint64_t count = bodies.size();
  for (const GroupDesc& group : groups) {
    count += group.layout == Layout::explicit_list ? group.x.size() : group.count;
  }
  return count;
}

std::optional<Scene> parse_scene(std::string_view text, std::string_view file, std::string& error) {
  error.clear();
  try {
    return read_scene(scene::read_document(text));
  } catch (const scene::SceneError& wrong) {
    error = error_line(text, file, wrong);
  } catch (const std::bad_alloc&) {
    error = scene::printable(file, 4096) + ": not enough memory to read this scene";
  } catch (const std::exception& wrong) {
    error = scene::printable(file, 4096) + ": " + scene::printable(wrong.what(), 200);
  }
  return std::nullopt;
}

std::optional<Scene> load_scene(const std::string& path, std::string& error) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 30;
  const std::string shown = scene::printable(path, 4096);
  try {
    std::string text;
    if (!read_file(path, kMostBytes, text)) {
      error = shown + ": cannot be read: " + std::strerror(errno);
      return std::nullopt;
    }
    if (text.size() > kMostBytes) {
      error = shown + ": too large for a scene file: at most 1 GiB";
      return std::nullopt;
    }
    return parse_scene(text, path, error);
  } catch (const std::bad_alloc&) {
    error = shown + ": not enough memory to read this file";
  }
  return std::nullopt;
}

}  // namespace psim
