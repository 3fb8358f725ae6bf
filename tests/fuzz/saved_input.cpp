// Packed states and recordings. A byte that changed is found by a checksum, so nothing behind it would ever be read:
// each input is played as it is, and, if it is refused, once more with sizes and checksums put right.
#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "inputs.h"
#include "picture/moment.h"
#include "picture/painter.h"
#include "picture/picture_view.h"
#include "psim/psim.h"
#include "psim/recording.h"
#include "psim/saved_state.h"
#include "psim/scene.h"
#include "world_promises.h"

namespace psim::fuzz {
namespace {

using Buffer = std::vector<std::byte>;

// Headers: of a packed state, of the state in it, of a recording. All are 64-bit numbers.
constexpr std::size_t kPackHeader = 32, kPackHash = 24;
constexpr std::size_t kStateHeader = 32, kStateSize = 16, kStateHash = 24;
constexpr std::size_t kRecordHeader = 48, kRecordSize = 16, kRecordHash = 24, kRecordState = 32, kRecordSteps = 40;

std::uint64_t number_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint64_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

void put_number(std::span<std::byte> bytes, std::size_t at, std::uint64_t value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

std::uint64_t hash(std::span<const std::byte> bytes) { return number_at(pack_state(bytes), kPackHash); }

void repair_state(std::span<std::byte> state) {
  if (state.size() < kStateHeader) return;
  put_number(state, kStateSize, state.size());
  put_number(state, kStateHash, hash(state.subspan(kStateHeader)));
}

std::string refusal(const std::string& error) {
  return !error.empty() && error.find_first_of("\r\n") == error.npos ? "" : "refused with: " + error;
}

// A world with something in it, that a refused state must leave alone.
std::unique_ptr<World> other_world(const WorldDesc& like) {
  std::string error;
  auto world = World::create(like, {}, error);
  if (!world) return nullptr;
  const Bounds& b = like.bounds;
  BodyDesc disc;
  disc.shape = DiscShape{(b.xmax - b.xmin) / 40};
  for (int k = 1; k < 6; ++k) {
    disc.position = {b.xmin + (b.xmax - b.xmin) * k / 6, b.ymin + (b.ymax - b.ymin) / 2};
    world->add_body(disc, error);
  }
  world->step();
  return world;
}

// The bounds of a state that cannot be restored are not to be had: of the corpus they are these.
std::string leaves_others_alone(std::span<const std::byte> state) {
  WorldDesc like;
  like.bounds = {-10, -10, 10, 10};
  const auto world = other_world(like);
  std::string error;
  const std::uint64_t before = world->state_hash();
  const std::size_t bodies = world->body_count();
  if (world->restore(state, error)) return {};
  if (world->state_hash() != before || world->body_count() != bodies) return "a refused state changed the world";
  world->step();
  const std::string fault = refusal(error);
  return fault.empty() ? broken_promise(*world) : fault;
}

// Pictures of every colouring, of a scene of as many discs.
void paint(World& world) {
  constexpr std::size_t kMostBodies = 1000;
  Scene scene;
  scene.world = world.desc();
  scene.bodies.resize(
      std::min(world.published().id.empty() ? 0 : world.published().id.back() + std::size_t{1}, kMostBodies));
  std::vector<std::uint8_t> rgb;
  for (std::size_t k = 0; k < cli::kColouringNames.size(); ++k) {
    cli::PictureOptions options;
    options.colouring = static_cast<cli::Colouring>(k);
    cli::Moment moment;
    cli::take_moment(world, moment, options.colouring);
    const cli::Painter painter(scene, options);
    cli::Canvas canvas(32, 24);
    const Bounds view = cli::view_of_all(scene, moment, painter.shapes());
    painter.paint(canvas, cli::PictureCamera(view, 32, 24), moment, cli::brightest(scene, moment, painter.shapes()));
    canvas.to_srgb(rgb, 1);
  }
}

std::string go_on(World& world) {
  paint(world);
  for (int k = 0; k < 3; ++k) world.step();
  std::string fault = broken_promise(world);
  Buffer again;
  world.save(again);
  std::string error;
  if (fault.empty() && !world.restore(again, error)) fault = "what it saves is refused: " + error;
  if (fault.empty()) world.step();
  std::vector<BodyId> all;
  for (const std::uint32_t id : world.published().id) all.push_back(world.id_of(id));
  for (const BodyId id : all) world.remove_body(id);
  world.step();
  if (fault.empty() && world.body_count() != 0) fault = "a body is not removed";
  return fault;
}

std::string state_fault(std::span<const std::byte> state) {
  std::string error;
  const auto world = World::from_state(state, {}, error);
  if (world) return go_on(*world);
  const std::string fault = refusal(error);
  return fault.empty() ? leaves_others_alone(state) : fault;
}

// Of a forged one a governor's step may be under way to the end, and what is no number stays until it is solved.
std::string recording_fault(std::span<const std::byte> recording, bool forged, bool& opened) {
  std::string error;
  const auto replay = Replay::open(recording, {}, error);
  opened = replay != nullptr;
  if (!replay) return refusal(error);
  constexpr std::uint64_t kMost = 60;  // steps
  while (replay->steps() < kMost && replay->next()) {
  }
  if (replay->differs_at() > std::max<std::uint64_t>(replay->steps(), 1)) return "a step that was not differs";
  if (replay->steps() < kMost && replay->next()) return "goes on after its end";
  if (!forged) return broken_promise(replay->world());
  return replay->world().published().id.size() <= replay->world().body_count() ? "" : "more rows than bodies";
}

}  // namespace

std::string saved_input(Bytes bytes) {
  const auto packed = std::as_bytes(bytes);
  std::string error;
  Buffer state;
  std::string fault;
  if (unpack_state(packed, state, error)) {
    fault = state_fault(state);
  } else {
    fault = refusal(error);
  }
  if (!fault.empty() || packed.size() < kPackHeader) return fault;
  const auto rest = packed.subspan(kPackHeader);
  Buffer repaired(rest.begin(), rest.end());
  repair_state(repaired);
  return repaired == state ? "" : state_fault(repaired);
}

std::string recording_input(Bytes bytes) {
  const auto recording = std::as_bytes(bytes);
  bool opened = false;
  const std::string fault = recording_fault(recording, false, opened);
  if (!fault.empty() || opened || recording.size() < kRecordHeader) return fault;
  Buffer repaired(recording.begin(), recording.end());
  const std::span<std::byte> all(repaired), rest = all.subspan(kRecordHeader);
  const std::uint64_t state = std::min<std::uint64_t>(number_at(all, kRecordState), rest.size());
  repair_state(rest.first(state));
  put_number(all, kRecordSize, all.size());
  put_number(all, kRecordState, state);
  put_number(all, kRecordHash, hash(rest) + 0x9E3779B97F4A7C15u * number_at(all, kRecordSteps));
  return recording_fault(repaired, true, opened);
}

}  // namespace psim::fuzz
