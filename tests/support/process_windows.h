// A program that a test starts, on Windows.
#pragma once

#include <windows.h>

#include <chrono>
#include <csignal>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "base/os.h"
#include "os/program.h"
#include "scratch_folder.h"

namespace psim::test {

/// Windows has no such signal. Tests send it to a Process alone, which then ends the program.
inline constexpr int SIGKILL = 9;

/// A program that is running.
class Process {
 public:
  Process(const std::string& program, std::vector<std::string> arguments) {
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
  ~Process() {
    if (process_ == nullptr) return;
    signal(SIGKILL);
    wait();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// SIGKILL ends the program, any other number is Ctrl-Break.
  void signal(int number) const {
    if (number == SIGKILL) {
      ::TerminateProcess(process_, kKilled);
    } else {
      ::GenerateConsoleCtrlEvent(CTRL_BREAK_EVENT, id_);
    }
  }

  /// Gives the program time to begin to listen; false if it ended before.
  bool waits_for(int) const { return ::WaitForSingleObject(process_, 1000) == WAIT_TIMEOUT; }

  Outcome wait() {
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

 private:
  static constexpr UINT kKilled = 0x6B696C6C;

  static HANDLE made(const std::string& name) {
    SECURITY_ATTRIBUTES inherited{sizeof inherited, nullptr, TRUE};
    return ::CreateFileW(os::path_of(name).c_str(), GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE, &inherited,
                         CREATE_ALWAYS, FILE_ATTRIBUTE_NORMAL, nullptr);
  }

  ScratchFolder scratch_;
  HANDLE process_ = nullptr;
  DWORD id_ = 0;
};

}  // namespace psim::test
