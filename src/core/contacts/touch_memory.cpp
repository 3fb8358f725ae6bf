#include "contacts/touch_memory.h"

#include <algorithm>
#include <bit>

#include "base/sort_keys.h"

namespace psim {
namespace {

std::size_t size_for(std::size_t touches) { return std::bit_ceil(std::max<std::size_t>(64, 4 * touches)); }

}  // namespace

// The slot that has a touch, or the free one where it belongs.
std::size_t TouchMemory::place_of(std::uint64_t key, TouchParts parts) const {
  const Touch sought{key, {}, {}, parts};
  std::size_t at =
      mixed(key ^ (std::uint64_t{parts.first} << 40 | std::uint64_t{parts.second} << 20)) & (slot_.size() - 1);
  while (slot_[at] != kFree && !list_[slot_[at]].same(sought)) at = (at + 1) & (slot_.size() - 1);
  return at;
}

void TouchMemory::add(const Touch& touch) {
  if (2 * (list_.size() + 1) > slot_.size()) rehash(size_for(list_.size() + 1));
  std::uint32_t& slot = slot_[place_of(touch.key, touch.parts)];
  if (slot != kFree) {
    list_[slot] = touch;
    return;
  }
  slot = static_cast<std::uint32_t>(list_.size());
  list_.push_back(touch);
}

void TouchMemory::rehash(std::size_t size) {
  slot_.assign(size, kFree);
  for (std::size_t k = 0; k < list_.size(); ++k)
    slot_[place_of(list_[k].key, list_[k].parts)] = static_cast<std::uint32_t>(k);
}

void TouchMemory::make_room(std::size_t touches) {
  list_.reserve(touches);
  const std::size_t size = size_for(touches / 2 + 1);  // half full
  if (size > slot_.size()) rehash(size);
}

void TouchMemory::make_room_for_more(std::size_t touches) {
  const std::size_t all = list_.size() + touches;
  if (all > list_.capacity()) list_.reserve(std::max(all, 2 * list_.capacity()));
  if (2 * all > slot_.size()) rehash(size_for(all));
}

const Touch* TouchMemory::find(std::uint64_t key, TouchParts parts) const {
  if (list_.empty()) return nullptr;
  const std::uint32_t slot = slot_[place_of(key, parts)];
  return slot == kFree ? nullptr : &list_[slot];
}

void TouchMemory::clear() {
  if (list_.empty()) return;
  list_.clear();
  std::fill(slot_.begin(), slot_.end(), kFree);
}

}  // namespace psim
