// Streams over bodies: integration and the columns that the broad phase starts from. Bodies are a
// gas; all of them are unlinked for Integrate (closed form and lattice fold) and linked for the
// substep kernels. Constants are such that velocities tend to some m/s, never to denormals.
#include <algorithm>
#include <cmath>
#include <memory>

#include "fixtures.h"
#include "workload.h"

namespace psim::bench {
namespace {

using kernels::BodyView;
using kernels::KernelTable;
using kernels::StreamParams;

// What a stream kernel works on; outputs go to columns that nothing else reads.
struct StreamState : Discs {
  StreamState(std::uint32_t n, std::uint8_t links)
      : Discs(scene_placement("discs", n)), params(stream_params(lattice)), block_end(blocks()) {
    std::fill_n(linked.data(), kernels::round_up_block(n), links);
    keys.reserve(kernels::round_up_block(n));
    params.damp = 0.99f;  // with the kick: tends to (1, -4) m/s
    params.kick_x = 0.01f;
    params.kick_y = -0.04f;
    params.smooth_limit2 = 1;
    for (Column<float>* c : {&acc, &vel_remainder, &disp_remainder, &correction}) {
      c->reserve(2 * kernels::round_up_block(n));
    }
    bodies = view();
    in_field = bodies;
    in_field.acc = acc.data();
    in_field.vel_remainder = vel_remainder.data();
    in_field.disp_remainder = disp_remainder.data();
    in_field.drift_correction = correction.data();
    well.strength = 1e-3;  // velocities hardly change
    well.softening2 = 1;
    well.range2 = 1e30;
    well.whole = 1;
    well.fraction = 1u << 31;
    field.wells = &well;
    field.well_count = 1;
    field.h = kStep;
    field.pitch_x = lattice.pitch_x();
    field.pitch_y = lattice.pitch_y();
    field.smooth = 1;
    grid.cols = grid.rows = static_cast<std::int32_t>(1.6 * std::sqrt(n)) + 1;
    grid.stride = static_cast<std::uint32_t>(grid.cols) + 1;
    grid.scale_x = grid.scale_y = static_cast<float>(grid.cols * 0x1p-30);
    grid.offset_x = grid.offset_y = static_cast<float>(grid.cols) / 2;
  }

  StreamParams params;
  std::uint32_t block_end;
  Column<std::uint32_t> keys{meter};
  Column<float> acc{meter}, vel_remainder{meter}, disp_remainder{meter}, correction{meter};
  BodyView bodies, in_field;
  kernels::WellTerms well;
  kernels::FieldParams field;
  kernels::GridView grid;
};

using StreamPass = void (*)(StreamState& s, const KernelTable& k);

template <kernels::Method kMethod>
void advance(StreamState& s, const KernelTable& k) {
  k.advance[static_cast<std::size_t>(kMethod)][0](s.in_field, s.field, 0, s.block_end);
}

class Stream : public Workload {
 public:
  Stream(std::uint32_t n, std::uint8_t linked, double bytes_a_body, StreamPass pass) : state_(n, linked), pass_(pass) {
    elements = n;
    bytes = bytes_a_body;
  }
  void pass(const KernelTable& k) override { pass_(state_, k); }

 private:
  StreamState state_;
  StreamPass pass_;
};

// Results that a kernel returns end here.
volatile float sink = 0;

struct Entry {
  const char* name;
  std::uint8_t linked;
  double bytes;  // records of 8, floats of 4, links of 1; read + written
  StreamPass pass;
};

constexpr Entry kStreams[] = {
    {"Integrate", 0, 25 + 24,
     [](StreamState& s, const KernelTable& k) {
       sink = k.integrate(s.bodies, s.params, 0, s.block_end) ? 1.0f : 0.0f;
     }},
    {"Kick", 0xFF, 9 + 16,
     [](StreamState& s, const KernelTable& k) { k.kick_first(s.bodies, s.params, 0, s.block_end); }},
    {"KickAgain", 0xFF, 17 + 16,
     [](StreamState& s, const KernelTable& k) { k.kick_again(s.bodies, s.params, 0, s.block_end); }},
    {"Drift", 0xFF, 25 + 8, [](StreamState& s, const KernelTable& k) { k.drift(s.bodies, s.params, 0, s.block_end); }},
    {"Accelerate", 0xFF, 25 + 8,  // one well of exponent 2, as the next four
     [](StreamState& s, const KernelTable& k) { k.accelerate[0](s.in_field, s.field, 0, s.block_end); }},
    {"AdvanceEuler", 0xFF, 41 + 40, advance<kernels::Method::euler>},
    {"AdvanceRk4", 0xFF, 41 + 40, advance<kernels::Method::rk4>},
    {"AdvanceSymplectic4", 0xFF, 41 + 40, advance<kernels::Method::symplectic4>},
    {"DriftBent", 0xFF, 49 + 16,
     [](StreamState& s, const KernelTable& k) { k.drift_corrected(s.in_field, s.field, 0, s.block_end); }},
    {"ListAge", 0, 32,
     [](StreamState& s, const KernelTable& k) {
       sink = k.list_age(s.bodies, s.built.data(), s.radius.data(), s.reach.data(), s.params, 0.02f, 0, s.block_end);
     }},
    {"Reaches", 0, 12 + 4,
     [](StreamState& s, const KernelTable& k) {
       sink = k.reaches(s.bodies, s.radius.data(), {.skin = 0.05f, .time = 0.02f}, s.reach.data(), 0, s.block_end);
     }},
    {"Extent", 0, 8,
     [](StreamState& s, const KernelTable& k) {
       std::int32_t low_high[4] = {};
       k.extent(s.pos.data(), low_high, 0, s.block_end);
       sink = static_cast<float>(low_high[0]);
     }},
    {"CellKeys", 0, 8 + 4,
     [](StreamState& s, const KernelTable& k) { k.cell_keys(s.pos.data(), s.grid, s.keys.data(), 0, s.block_end); }},
};

}  // namespace

void register_stream_kernels() {
  for (const Entry& e : kStreams) {
    register_kernel(e.name, [e](std::uint32_t n) { return std::make_unique<Stream>(n, e.linked, e.bytes, e.pass); });
  }
}

}  // namespace psim::bench
