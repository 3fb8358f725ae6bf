psim_headers(fmt::fmt fmt)
if(TARGET fmt::fmt)
  target_compile_definitions(fmt::fmt INTERFACE FMT_HEADER_ONLY=1)
endif()
