// A profiler for tests, as a host would name it by PSIM_PROFILE_HEADER: it keeps every zone of every thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

class PsimZone;

struct ZoneSeen {
  std::string name;
  std::thread::id thread;
  std::size_t depth = 0;  // zones of the thread that it lies in
};

struct ZonesSeen {
  std::mutex mutex;
  std::vector<ZoneSeen> ended;
  std::atomic<int> begun{0};
  std::atomic<bool> nested{true};  // no zone ended before one that began later on its thread
};

inline ZonesSeen zones_seen;
inline thread_local std::vector<const PsimZone*> open_zones;

class PsimZone {
 public:
  explicit PsimZone(const char* name) : name_(name) {
    ++zones_seen.begun;
    open_zones.push_back(this);
  }
  ~PsimZone() {
    if (open_zones.empty() || open_zones.back() != this) zones_seen.nested = false;
    open_zones.pop_back();
    const std::lock_guard lock(zones_seen.mutex);
    zones_seen.ended.push_back({name_, std::this_thread::get_id(), open_zones.size()});
  }
  PsimZone(const PsimZone&) = delete;
  PsimZone& operator=(const PsimZone&) = delete;

 private:
  const char* name_;
};
