#include <fcntl.h>
#include <io.h>
#include <windows.h>
// After windows.h:
#include <psapi.h>
#include <shellapi.h>

#include <atomic>
#include <cerrno>
#include <cstdio>

#include "base/os.h"
#include "os/console.h"
#include "os/interrupt.h"

namespace psim::os {
namespace {

std::atomic<bool> interrupt_flag = false;

// Runs on a thread of its own.
BOOL WINAPI on_console_event(DWORD event) {
  const bool first = !interrupt_flag.exchange(true);
  if (event == CTRL_C_EVENT || event == CTRL_BREAK_EVENT) return first ? TRUE : FALSE;  // FALSE: the process ends
  ::Sleep(INFINITE);  // the console closes: the process ends when this returns, or when the run is over
  return TRUE;
}

}  // namespace

Console::Console() : code_page_(::GetConsoleOutputCP()) {
  ::SetConsoleOutputCP(CP_UTF8);
  ::_setmode(::_fileno(stdout), _O_BINARY);
  ::_setmode(::_fileno(stderr), _O_BINARY);
  const HANDLE screen = ::GetStdHandle(STD_ERROR_HANDLE);
  if (DWORD mode = 0; ::GetConsoleMode(screen, &mode) != 0) {
    ::SetConsoleMode(screen, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);  // the line of progress is wiped by a code
  }
}

Console::~Console() {
  if (code_page_ != 0) ::SetConsoleOutputCP(code_page_);
}

std::vector<std::string> command_line(int argc, const char* const* argv) {
  int count = 0;
  wchar_t** const words = ::CommandLineToArgvW(::GetCommandLineW(), &count);
  if (words == nullptr) return {argv, argv + argc};
  std::vector<std::string> utf8;
  for (int k = 0; k < count; ++k) utf8.push_back(name_of(words[k]));
  ::LocalFree(words);
  return utf8;
}

bool stderr_is_terminal() { return ::_isatty(::_fileno(stderr)) != 0; }

std::uint64_t available_bytes() {
  MEMORYSTATUSEX memory{};
  memory.dwLength = sizeof memory;
  ::GlobalMemoryStatusEx(&memory);
  return memory.ullAvailPhys < memory.ullAvailPageFile ? memory.ullAvailPhys : memory.ullAvailPageFile;
}

std::uint64_t page_faults() {
  PROCESS_MEMORY_COUNTERS memory{};
  memory.cb = sizeof memory;
  return ::K32GetProcessMemoryInfo(::GetCurrentProcess(), &memory, sizeof memory) != 0 ? memory.PageFaultCount : 0;
}

// Whether its files may be written is up to access lists: the first file will tell.
int folder_error(const std::string& folder) {
  const DWORD attributes = ::GetFileAttributesW(path_of(folder).c_str());
  if (attributes == INVALID_FILE_ATTRIBUTES) return ENOENT;
  return (attributes & FILE_ATTRIBUTE_DIRECTORY) != 0 ? 0 : ENOTDIR;
}

void catch_interrupts() { ::SetConsoleCtrlHandler(on_console_event, TRUE); }

bool interrupted() { return interrupt_flag; }

}  // namespace psim::os
