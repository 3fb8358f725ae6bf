#include "query/question.h"

#include <algorithm>

namespace psim {

Vec2 Question::one_way(const QueryIndex::Part& part, const QueryItem& item) const {
  const BodyProperties& properties = world.bodies.properties(item.body);
  const BodyKind& kind = world.bodies.kinds[properties.kind];
  if (!kind.one_way) return {};
  const Vec2 way = world.bodies.one_way_of(kind, item.part);
  if (way == Vec2{} || properties.type() == BodyType::static_body) return way;
  const Vec2 turn = part.pieces[item.piece].way;  // a plain disc has none
  return turned({turn.y, turn.x}, way);
}

void Question::gather(const Outline& shape, Vec2 middle, Vec2 half, std::vector<std::uint32_t>& ids) const {
  parts([&](const QueryIndex::Part& part) {
    QueryIndex::each_overlap(
        world, part, shape, place(middle), half, [&](const QueryItem& item) { return wants(item); },
        [&](std::uint32_t id) { ids.push_back(id); });
  });
}

std::vector<BodyId> Question::answer(std::vector<std::uint32_t> ids) const {
  sort_keys(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  std::vector<BodyId> out;
  out.reserve(ids.size());
  for (const std::uint32_t id : ids) out.push_back(world.handle(id));
  return out;
}

}  // namespace psim
