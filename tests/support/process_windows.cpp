#include "process_windows.h"

#include <windows.h>

#include <stdexcept>

#include "base/os.h"
#include "os/program.h"

namespace psim::test {
namespace {

constexpr UINT kKilled = 0x6B696C6C;
constexpr DWORD kTimeToListen_ms = 300;

HANDLE made(const std::string& name) {
  SECURITY_ATTRIBUTES inherited{sizeof inherited, nullptr, TRUE};
  return ::CreateFileW(os::path_of(name).c_str(), GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE, &inherited,
                       CREATE_ALWAYS, FILE_ATTRIBUTE_NORMAL, nullptr);
}

}  // namespace

Process::Process(const std::string& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), program);
  std::wstring line = os::path_of(os::quoted(arguments)).wstring();
  STARTUPINFOW start{};
  start.cb = sizeof start;
  start.dwFlags = STARTF_USESTDHANDLES;
  start.hStdInput = ::GetStdHandle(STD_INPUT_HANDLE);
  start.hStdOutput = made(scratch_.file("out"));
  start.hStdError = made(scratch_.file("err"));
  PROCESS_INFORMATION process{};
  const BOOL started = ::CreateProcessW(os::path_of(program).c_str(), line.data(), nullptr, nullptr, TRUE,
                                        CREATE_NEW_PROCESS_GROUP, nullptr, nullptr, &start, &process);
  ::CloseHandle(start.hStdOutput);
  ::CloseHandle(start.hStdError);
  if (started == 0) throw std::runtime_error(program + " does not start");
  ::CloseHandle(process.hThread);
  process_ = process.hProcess;
  id_ = process.dwProcessId;
}

Process::~Process() {
  if (process_ == nullptr) return;
  signal(SIGKILL);
  wait();
}

void Process::signal(int number) const {
  if (number == SIGKILL) {
    ::TerminateProcess(process_, kKilled);
  } else {
    ::GenerateConsoleCtrlEvent(CTRL_BREAK_EVENT, id_);
  }
}

bool Process::waits_for(int) const { return ::WaitForSingleObject(process_, kTimeToListen_ms) == WAIT_TIMEOUT; }

Outcome Process::wait() {
  ::WaitForSingleObject(process_, INFINITE);
  DWORD status = 0;
  ::GetExitCodeProcess(process_, &status);
  ::CloseHandle(process_);
  process_ = nullptr;
  Outcome outcome;
  outcome.status = status == kKilled ? -SIGKILL : static_cast<int>(status);
  outcome.out = read_file(scratch_.file("out"));
  outcome.err = read_file(scratch_.file("err"));
  return outcome;
}

}  // namespace psim::test
