// A program that takes the place of ffmpeg in tests of every system. The environment says what it does: PSIM_STAND_IN is
// `fail` (it says two lines and ends with 3), `nothing` (it ends well without a film), or not there (it counts the bytes
// of its input and writes the count to the file that its last word names).
#include <cstdio>
#include <cstdlib>
#include <string>
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
#endif

int main(int argc, char** argv) {
#ifdef _WIN32
  _setmode(_fileno(stdin), _O_BINARY);
#endif
  const char* const what = std::getenv("PSIM_STAND_IN");
  const std::string mode = what != nullptr ? what : "";
  if (mode == "nothing") return 0;
  if (mode == "fail") {
    std::fputs("it begins\nout of paper\n\n", stderr);
    return 3;
  }
  const std::string target = argv[argc - 1], prefix = "file:";
  if (target.rfind(prefix, 0) != 0) return 2;
  std::size_t bytes = 0;
  char part[4096];
  for (std::size_t n; (n = std::fread(part, 1, sizeof part, stdin)) > 0;) bytes += n;
  std::FILE* const film = std::fopen(target.c_str() + prefix.size(), "wb");
  if (film == nullptr) return 4;
  std::fprintf(film, "%zu", bytes);
  return std::fclose(film) == 0 ? 0 : 5;
}
