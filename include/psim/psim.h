// psim: a 2D real-time physics engine for very many bodies. Include this one header. From C it is
// the C API, <psim.h>.
#pragma once

#ifdef __cplusplus
#include "psim/contact.h"
#include "psim/debug_draw.h"
#include "psim/desc.h"
#include "psim/events.h"
#include "psim/fluid.h"
#include "psim/geometry.h"
#include "psim/integrator.h"
#include "psim/isa.h"
#include "psim/joint.h"
#include "psim/limits.h"
#include "psim/mover.h"
#include "psim/outline.h"
#include "psim/query.h"
#include "psim/recording.h"
#include "psim/report.h"
#include "psim/saved_state.h"
#include "psim/types.h"
#include "psim/version.h"
#include "psim/world.h"
#else
#include <psim.h>
#endif
