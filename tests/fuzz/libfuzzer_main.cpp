// One program an input: PSIM_FUZZ_INPUT names the function of inputs.h.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "inputs.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string fault = psim::fuzz::PSIM_FUZZ_INPUT({data, size});
  if (fault.empty()) return 0;
  std::fprintf(stderr, "fault: %s\n", fault.c_str());
  std::abort();
}
