// What every body looks like and weighs, by id: what a snapshot does not tell.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "psim/scene.h"

namespace psim::view {

/// One shape that bodies share. Kind 0 is the disc, whose radius is the snapshot's.
struct Kind {
  std::vector<Vec2> points;  ///< metres, body frame
  double radius = 0;         ///< around the points
  double reach = 0;          ///< of the circle about the origin that holds it
  bool line = false;         ///< segments from point to point instead of an area; of a compound: a part is one
  bool loop = false;
  double area = 0;                   ///< m^2: mass / density; of a line its length, m
  std::vector<std::uint32_t> parts;  ///< kinds; of a compound, which has no points of its own
};

inline constexpr std::uint32_t kDiscKind = 0;
inline constexpr std::uint32_t kKindMask = 0x00FFFFFFu;
inline constexpr std::uint32_t kStaticBit = 1u << 24;
inline constexpr std::uint32_t kKinematicBit = 1u << 25;
inline constexpr std::uint32_t kSensorBit = 1u << 26;

class Catalogue {
 public:
  explicit Catalogue(const Scene& scene);

  /// Notes a body that was added later; an id that was in use before is taken over.
  void set(std::uint32_t id, const BodyDesc& body, BodyType type);
  /// Nothing is drawn of a body.
  void hide(std::uint32_t id);

  /// Kind and bits of a body.
  std::uint32_t look(std::uint32_t id) const { return id < looks_.size() ? looks_[id] : 0; }
  const std::vector<std::uint32_t>& looks() const { return looks_; }
  const std::vector<Kind>& kinds() const { return kinds_; }
  const Kind& kind(std::uint32_t id) const { return kinds_[look(id) & kKindMask]; }
  bool hidden(std::uint32_t look) const { return (look & kKindMask) == hidden_kind_; }
  /// kg; `disc_radius` is used for discs only.
  double mass(std::uint32_t id, double disc_radius) const;
  bool has_areas() const { return has_areas_; }  ///< any kind but discs and lines
  bool has_lines() const { return has_lines_; }
  bool has_compounds() const { return has_compounds_; }

 private:
  std::uint32_t look_of(const BodyDesc& body, BodyType type);
  std::uint32_t kind_of(Kind kind);

  std::vector<Kind> kinds_{Kind{}};
  std::unordered_map<std::string, std::uint32_t> known_;  // bytes of a shape -> kind
  std::vector<std::uint32_t> looks_;                      // by id
  std::vector<float> density_, mass_;                     // by id: kg/m^2, kg where the description says so, else 0
  std::uint32_t hidden_kind_ = kKindMask;                 // without points, once there is one
  bool has_areas_ = false, has_lines_ = false, has_compounds_ = false;
};

}  // namespace psim::view
