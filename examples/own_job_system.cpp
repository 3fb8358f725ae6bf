// psim on the host's threads: here a small pool, in an engine its job system. The result has the same
// bits as on psim's own threads, or on none.
#include <psim/psim.h>

#include <atomic>
#include <barrier>
#include <cstdio>
#include <string>
#include <thread>
#include <utility>
#include <vector>

class Pool {
 public:
  using Job = std::function<void(std::size_t)>;

  explicit Pool(int threads) : gate_(threads + 1) {
    for (int k = 0; k < threads; ++k) threads_.emplace_back([this] { work(); });
  }
  ~Pool() {
    job_ = nullptr;
    gate_.arrive_and_wait();
  }

  // Runs job(0..count-1) on all threads, this one too, and returns when all are done.
  void run(std::size_t count, const Job& job) {
    job_ = &job;
    count_ = count;
    next_ = 0;
    gate_.arrive_and_wait();
    take();
    gate_.arrive_and_wait();
  }

 private:
  void take() {
    for (std::size_t i = next_++; i < count_; i = next_++) (*job_)(i);
  }
  void work() {
    for (;;) {
      gate_.arrive_and_wait();
      if (job_ == nullptr) return;
      take();
      gate_.arrive_and_wait();
    }
  }

  std::barrier<> gate_;
  const Job* job_ = nullptr;
  std::size_t count_ = 0;
  std::atomic<std::size_t> next_{0};
  std::vector<std::jthread> threads_;  // last: joined before the rest goes
};

std::uint64_t hash_of_a_pile(psim::JobSystem jobs) {
  std::string error;
  const auto world = psim::World::create({}, {}, error);
  for (int k = 0; k < 3000; ++k) {
    psim::BodyDesc disc;
    disc.position = {k % 60 * 1.01, k / 60 * 1.01 - 499};
    world->add_body(disc, error);
  }
  world->set_job_system(std::move(jobs));
  for (int frame = 0; frame < 60; ++frame) world->step();
  return world->state_hash();
}

int main() {
  Pool pool(3);
  const std::uint64_t alone = hash_of_a_pile({});
  const std::uint64_t pooled =
      hash_of_a_pile({.parallel_for = [&](std::size_t n, const Pool::Job& job) { pool.run(n, job); }, .workers = 4});
  std::printf("%016llx on one thread\n%016llx on the pool\n", static_cast<unsigned long long>(alone),
              static_cast<unsigned long long>(pooled));
  return alone == pooled ? 0 : 1;
}
