// The kernels of one ISA as function pointers. A world keeps a copy; pointers are taken per range,
// never per contact. Every function is pure over its views. Tables are constant-initialised, so
// that nothing of an ISA runs before it was chosen.
#pragma once

#include <cstdint>

#include "collide_views.h"
#include "fluid_views.h"
#include "joint_views.h"
#include "lasting_views.h"
#include "manifold_views.h"
#include "views.h"

namespace psim::kernels {

using Block = std::uint32_t;  // the number of a block: the first one, or the one past the last

struct KernelTable {
  std::uint32_t width;  // lanes of a register
  // Streams over bodies (stream_kernel.h).
  void (*kick_first)(const BodyView&, const StreamParams&, Block, Block);
  void (*kick_again)(const BodyView&, const StreamParams&, Block, Block);
  void (*drift)(const BodyView&, const StreamParams&, Block, Block);
  bool (*integrate)(const BodyView&, const StreamParams&, Block, Block);
  float (*list_age)(const BodyView&, const std::int32_t* built, const float* radius, const float* reach,
                    const StreamParams&, float reach_time, Block, Block);
  void (*look_ahead)(const BodyView&, const StreamParams&, float ahead, std::int32_t* place, Block, Block);
  float (*reaches)(const BodyView&, const float* radius, const ReachParams&, float* reach, Block, Block);
  void (*extent)(const std::int32_t* pos, std::int32_t low_high[4], Block, Block);
  void (*cell_keys)(const std::int32_t* pos, const GridView&, std::uint32_t* key, Block, Block);
  // Smooth forces (field_kernel.h), by whether there is drag: quadratic for accelerate, any for
  // advance.
  void (*accelerate[2])(const BodyView&, const FieldParams&, Block, Block);
  void (*advance[kMethods][2])(const BodyView&, const FieldParams&, Block, Block);
  void (*drift_corrected)(const BodyView&, const FieldParams&, Block, Block);
  // Pair search (pair_kernel.h): bodies, not blocks.
  bool (*find_pairs)(const PairRow&, std::uint32_t begin, std::uint32_t end, PairList&);
  bool (*find_near)(const PairRow&, std::uint32_t i, std::uint32_t j0, std::uint32_t j1, PairList&);
  std::uint32_t (*select_pairs)(const BodyView&, const PairSelection&, std::uint32_t begin, std::uint32_t end);
  // Contacts (contact_kernel.h, static_contact_kernel.h, impact_kernel.h), by model, and by restitution and sweep.
  void (*prepare)(const BodyView&, const ContactView&, const ContactParams&, Block, Block);
  void (*warm[kModels])(const BodyView&, const ContactView&, const ContactParams&, Block, Block);
  void (*solve[kModels][kBounces])(const BodyView&, const ContactView&, const ContactParams&, Block, Block);
  void (*relax[kModels][kBounces])(const BodyView&, const ContactView&, const ContactParams&, Block, Block);
  void (*spend[kModels])(const BodyView&, const ContactView&, const ContactParams&, Block, Block);
  bool (*sweep[kModels][kSweeps])(const BodyView&, const ContactView&, const ContactParams&, Block, Block,
                                  double* virial);
  void (*warm_static[kModels])(const BodyView&, const StaticContactView&, const ContactParams&, Block, Block);
  void (*solve_static[kModels][kBounces])(const BodyView&, const StaticContactView&, const ContactParams&, Block,
                                          Block);
  void (*relax_static[kModels][kBounces])(const BodyView&, const StaticContactView&, const ContactParams&, Block,
                                          Block);
  void (*spend_static[kModels])(const BodyView&, const StaticContactView&, const ContactParams&, Block, Block);
  bool (*sweep_static[kModels][kSweeps])(const BodyView&, const StaticContactView&, const ContactParams&, Block, Block,
                                         double* virial);
  // Manifolds (manifold_kernel.h), by whether A is fixed; solve and relax also by restitution and by whether the sweep
  // is an inner one.
  void (*warm_manifolds[2])(const BodyView&, ManifoldBlock*, SurfaceBlock*, float scale, Block, Block);
  void (*solve_manifolds[2][2][2])(const BodyView&, ManifoldBlock*, const ContactParams&, Block, Block);
  void (*relax_manifolds[2][2][2])(const BodyView&, ManifoldBlock*, SurfaceBlock*, const ContactParams&, Block, Block);
  void (*spend_manifolds[2])(const BodyView&, ManifoldBlock*, const ContactParams&, Block, Block);
  void (*turn_bodies)(const BodyView&, const float* radius, const StreamParams&, Block, Block);
  // Manifolds that last (lasting_kernel.h), by whether A is fixed.
  void (*last_manifolds[2])(const BodyView&, const LastingColumns&, ManifoldBlock*, const LastingBlock*,
                            const LastingParams&, std::uint8_t* steady, Block, Block);
  // Contacts of hulls (collide_kernel.h): of A with 2, up to 4 or up to 8 vertices and B with a disc's
  // one or those.
  using Collide = void (*)(HullPairs*, Block, Block);
  Collide collide[3][4];
  // Joints (joint_*_kernel.h), by kind and whether A is fixed.
  using JointPass = void (*)(const BodyView&, JointBlocks, const JointParams&, Block, Block);
  JointPass warm_joints[kJointKinds][2];
  JointPass solve_joints[kJointKinds][2];
  JointPass relax_joints[kJointKinds][2];
  JointPass push_joints[kJointKinds][2];
  void (*part_joints)(const BodyView&, const JointShare&, Block, Block);
  void (*hold_joints)(const BodyView&, const JointShare&, const StreamParams&, Block, Block);
  void (*let_go_joints)(const BodyView&, const JointShare&, Block, Block);
  // Fluids (fluid_particle_kernel.h, fluid_grid_kernel.h): particles and fields of one tile.
  void (*scatter_fluid)(const FluidParticle*, std::size_t count, const FluidMotion&, const FluidSums&);
  void (*gather_fluid)(FluidParticle*, std::size_t count, const FluidMotion&, const FluidFields&);
  void (*move_fluid)(FluidParticle*, std::size_t count, const FluidMotion&);
  void (*begin_fluid)(const FluidLevel&, const float* right, float first, float second, float* x);
  double (*smooth_fluid)(const FluidLevel&, const float* right, float weight, const float* x, float* to);
  void (*fluid_residual)(const FluidLevel&, const float* right, const float* x, float* residual);
  void (*prolong_fluid)(const FluidLevel&, const float* coarse, float* x);
  double (*turn_fluid)(const FluidLevel&, const float* z, float share, float* way, float* change);
  float (*advance_fluid)(float step, const float* way, const float* change, float* x, float* residual);
};

extern const KernelTable kScalarKernels;
extern const KernelTable kSseKernels;
extern const KernelTable kAvx2Kernels;
extern const KernelTable kNeonKernels;
extern const KernelTable kWasmKernels;

}  // namespace psim::kernels
