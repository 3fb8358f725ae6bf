// Passes over contacts. The state is a hexagonal block of `size` discs, about three contacts a
// disc; elements are contacts, so padding lanes count as cost. No gravity; velocities are small and
// random, and the state is put back every few passes.
#include <limits>
#include <memory>

#include "fixtures.h"
#include "hex_pile.h"
#include "workload.h"

namespace psim::bench {
namespace {

using kernels::BodyView;
using kernels::ContactParams;
using kernels::ContactView;
using kernels::KernelTable;
using kernels::Model;

// Passes between restarts: some hundred microseconds at least, so that stopping the clock does not
// show, and few enough for values to stay far from zero.
int passes_for(std::uint32_t size) { return size <= 1'000 ? 64 : size <= 10'000 ? 32 : size <= 100'000 ? 8 : 2; }

using ContactPass = void (*)(const KernelTable& k, const BodyView& b, const ContactView& c, const ContactParams& p,
                             std::uint32_t blocks);

struct ContactEntry {
  const char* name;
  bool rough;    ///< friction: bodies turn
  double bytes;  // a contact: 8 for its two slots, 8 a body record, 4 a float; read + written
  ContactPass pass;
};

constexpr auto kPlain = static_cast<std::size_t>(Model::plain);
constexpr auto kRough = static_cast<std::size_t>(Model::rough);

constexpr ContactEntry kContacts[] = {
    // n and gap written; places, radii read.
    {"NarrowPhase", false, 8 + 16 + 4 + 12,
     [](const KernelTable& k, const BodyView& b, const ContactView& c, const ContactParams& p, std::uint32_t blocks) {
       k.prepare(b, c, p, 0, blocks);
     }},
    // n; impulse and velocities twice.
    {"WarmStart", false, 8 + 8 + 8 + 32,
     [](const KernelTable& k, const BodyView& b, const ContactView& c, const ContactParams& p, std::uint32_t blocks) {
       k.warm[kPlain](b, c, p, 0, blocks);
     }},
    // n, gap, offsets; impulse and velocities twice.
    {"SolveContacts", false, 8 + 12 + 16 + 8 + 32,
     [](const KernelTable& k, const BodyView& b, const ContactView& c, const ContactParams& p, std::uint32_t blocks) {
       k.solve[kPlain][0](b, c, p, 0, blocks);
     }},
    {"RelaxContacts", false, 8 + 8 + 8 + 32,
     [](const KernelTable& k, const BodyView& b, const ContactView& c, const ContactParams& p, std::uint32_t blocks) {
       k.relax[kPlain][0](b, c, p, 0, blocks);
     }},
    // And three masses.
    {"SolveRough", true, 8 + 12 + 16 + 8 + 32 + 12,
     [](const KernelTable& k, const BodyView& b, const ContactView& c, const ContactParams& p, std::uint32_t blocks) {
       k.solve[kRough][0](b, c, p, 0, blocks);
     }},
    // And three masses, mu, tmass, two q; friction impulse and two spins twice.
    {"RelaxRough", true, 8 + 8 + 8 + 32 + 12 + 16 + 8 + 16,
     [](const KernelTable& k, const BodyView& b, const ContactView& c, const ContactParams& p, std::uint32_t blocks) {
       k.relax[kRough][0](b, c, p, 0, blocks);
     }},
};

// Discs in touch: neighbours overlap by a thousandth of a diameter.
class Contacts : public Workload {
 public:
  Contacts(std::uint32_t n, const ContactEntry& entry)
      : pile_(n, 0.999 * 2 * kRadius, 0.01),
        pass_(entry.pass),
        params_(contact_params(pile_.lattice)),
        bodies_(pile_.view()),
        contacts_(pile_.contacts()) {
    Random random(2);
    for (std::size_t l = 0; l < pile_.lanes(); ++l) {
      if (pile_.is_contact(l)) pile_.impulse[l] = static_cast<float>(random.uniform(0.01, 0.02));
    }
    start_.keep(pile_.vel, 2 * std::size_t{n});
    start_.keep(pile_.impulse, pile_.lanes());
    if (entry.rough) {
      for (std::uint32_t i = 0; i < n; ++i) {
        pile_.rim_speed[i] = static_cast<float>(random.uniform(-0.01, 0.01));
      }
      start_.keep(pile_.rim_speed, n);
      start_.keep(pile_.friction, pile_.lanes());
    }
    elements = pile_.contact_count;
    bytes = entry.bytes;
    passes_a_start = passes_for(n);
  }

  void pass(const KernelTable& k) override { pass_(k, bodies_, contacts_, params_, pile_.blocks_of_contacts); }
  void restart() override { start_.restore(); }

 private:
  HexPile pile_;
  ContactPass pass_;
  ContactParams params_;
  BodyView bodies_;
  ContactView contacts_;
  Saved start_;
};

// The first of a substep's time-of-impact sweeps, restitution 0.5, over discs 2 cm apart at up to
// 4 m/s an axis; about one contact in fifteen is hit. A sweep changes
// anew.
class ImpactSweep : public Workload {
 public:
  explicit ImpactSweep(std::uint32_t n)
      : pile_(n, 1.02 * 2 * kRadius, 4),
        params_(contact_params(pile_.lattice)),
        bodies_(pile_.view()),
        contacts_(pile_.contacts()) {
    params_.bounce_floor = 0.02f;
    for (Column<float>* column : {&pile_.vel, &pile_.disp, &pile_.vel0}) {
      start_.keep(*column, 2 * std::size_t{n});
    }
    start_.keep(pile_.event_time, n);
    elements = pile_.contact_count;
    // Slots, e, radii; the mark twice; times, places, offsets and velocities of both bodies. What
    // a hit writes is not counted.
    bytes = 8 + 8 + 8 + 8 + 16 + 16 + 16;
    passes_a_start = 1;
  }

  void pass(const KernelTable& k) override {
    k.sweep[kPlain][0](bodies_, contacts_, params_, 0, pile_.blocks_of_contacts, &virial_);
  }
  void restart() override { start_.restore(); }

 private:
  HexPile pile_;
  ContactParams params_;
  BodyView bodies_;
  ContactView contacts_;
  Saved start_;
  double virial_ = 0;
};

// `size` discs in a row on a flat floor, one contact each.
class Statics : public Workload {
 public:
  explicit Statics(std::uint32_t n)
      : discs_(row(n)), params_(contact_params(discs_.lattice)), blocks_(discs_.blocks()) {
    const std::size_t lanes = std::size_t{blocks_} * kernels::kBlock;
    body_.reserve(lanes);
    for (Column<float>* c : {&nx_, &ny_, &gap_, &zero_, &refresh_, &impulse_}) c->reserve(lanes);
    for (std::uint32_t l = 0; l < lanes; ++l) {
      body_[l] = l;  // the last block's padding are bodies at rest
      ny_[l] = 1;
      gap_[l] = -0.001f;
      refresh_[l] = std::numeric_limits<float>::infinity();
      impulse_[l] = 0.01f;
    }
    view_.body = body_.data();
    view_.nx = nx_.data();
    view_.ny = ny_.data();
    view_.gap = gap_.data();
    view_.impulse = impulse_.data();
    view_.base_x = view_.base_y = view_.rsum = zero_.data();
    view_.refresh = refresh_.data();
    bodies_ = discs_.view();
    start_.keep(discs_.vel, 2 * lanes);
    start_.keep(impulse_, lanes);
    elements = n;
    bytes = 4 + 8 + 4 + 4 + 8 + 8 + 16;  // slot, n, gap, refresh, offset; impulse, velocity twice
    passes_a_start = 2 * passes_for(n);
  }

  void pass(const KernelTable& k) override { k.solve_static[kPlain][0](bodies_, view_, params_, 0, blocks_); }
  void restart() override { start_.restore(); }

 private:
  static Placement row(std::uint32_t n) {
    Random random(1);
    Placement p;
    for (std::uint32_t i = 0; i < n; ++i) {
      p.x.push_back(2 * kRadius * i);
      p.y.push_back(kRadius);
      p.vx.push_back(random.uniform(-0.01, 0.01));
      p.vy.push_back(random.uniform(-0.01, 0.01));
    }
    p.bounds = {-1, 0, 2 * kRadius * n, 2};
    return p;
  }

  Discs discs_;
  ContactParams params_;
  std::uint32_t blocks_;
  Column<std::uint32_t> body_{discs_.meter};
  Column<float> nx_{discs_.meter}, ny_{discs_.meter}, gap_{discs_.meter}, zero_{discs_.meter}, refresh_{discs_.meter},
      impulse_{discs_.meter};
  BodyView bodies_;
  kernels::StaticContactView view_;
  Saved start_;
};

}  // namespace

void register_contact_kernels() {
  for (const ContactEntry& e : kContacts) {
    register_kernel(e.name, [e](std::uint32_t n) { return std::make_unique<Contacts>(n, e); });
  }
  register_kernel("ImpactSweep", [](std::uint32_t n) { return std::make_unique<ImpactSweep>(n); });
  register_kernel("SolveStaticContacts", [](std::uint32_t n) { return std::make_unique<Statics>(n); });
}

}  // namespace psim::bench
