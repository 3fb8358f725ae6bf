#include <io.h>
#include <windows.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "base/os.h"
#include "os/program.h"

namespace psim::os {
namespace {

constexpr DWORD kPipeBytes = 1 << 20;

void close_once(HANDLE& handle) {
  if (handle != nullptr && handle != INVALID_HANDLE_VALUE) ::CloseHandle(handle);
  handle = nullptr;
}

[[noreturn]] void refuse(const char* what) {
  throw std::system_error(static_cast<int>(::GetLastError()), std::system_category(), what);
}

// A file that is gone with its last handle. The other program inherits it.
HANDLE open_messages(SECURITY_ATTRIBUTES& inherited) {
  std::array<wchar_t, MAX_PATH + 1> folder{}, name{};
  if (::GetTempPathW(MAX_PATH, folder.data()) == 0) return nullptr;
  if (::GetTempFileNameW(folder.data(), L"psi", 0, name.data()) == 0) return nullptr;
  const HANDLE file =
      ::CreateFileW(name.data(), GENERIC_READ | GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE, &inherited,
                    CREATE_ALWAYS, FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE, nullptr);
  return file == INVALID_HANDLE_VALUE ? nullptr : file;
}

std::string read_all(HANDLE file) {
  std::string text;
  std::array<char, 4096> part;
  ::SetFilePointer(file, 0, nullptr, FILE_BEGIN);
  for (DWORD n = 0; ::ReadFile(file, part.data(), part.size(), &n, nullptr) != 0 && n > 0;) text.append(part.data(), n);
  return text;
}

}  // namespace

struct PipedProgram::Process {
  HANDLE id = nullptr;
  HANDLE pipe = nullptr;      // to its stdin
  HANDLE messages = nullptr;  // its stderr
};

std::string quoted(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string_view word : words) {
    if (!line.empty()) line += ' ';
    line += '"';
    std::size_t backslashes = 0;
    for (const char c : word) {
      if (c == '"') line.append(backslashes + 1, '\\');
      backslashes = c == '\\' ? backslashes + 1 : 0;
      line += c;
    }
    line.append(backslashes, '\\');
    line += '"';
  }
  return line;
}

bool can_start_programs() { return true; }

std::string find_program(std::string_view name) {
  const wchar_t* const path = ::_wgetenv(L"PATH");
  std::wstring_view left = path != nullptr ? path : L"";
  while (!left.empty()) {
    const std::size_t end = std::min(left.find(L';'), left.size());
    const std::filesystem::path program =
        std::filesystem::path(left.substr(0, end)) / path_of(std::string(name) + ".exe");
    std::error_code ignored;
    if (end > 0 && is_regular_file(program, ignored)) return name_of(program);
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  return {};
}

// The file is not handed on: the other program opens it by its name.
PipedProgram::PipedProgram(const std::vector<std::string>& words, int) : process_(std::make_unique<Process>()) {
  SECURITY_ATTRIBUTES inherited{sizeof inherited, nullptr, TRUE};
  HANDLE input = nullptr;
  if (::CreatePipe(&input, &process_->pipe, &inherited, kPipeBytes) == 0) refuse("no pipe to it");
  ::SetHandleInformation(process_->pipe, HANDLE_FLAG_INHERIT, 0);
  process_->messages = open_messages(inherited);
  std::wstring line = path_of(quoted(words)).wstring();

  STARTUPINFOW start{};
  start.cb = sizeof start;
  start.dwFlags = STARTF_USESTDHANDLES;
  start.hStdInput = input;
  start.hStdOutput = process_->messages;
  start.hStdError = process_->messages;
  PROCESS_INFORMATION made{};
  const BOOL started = ::CreateProcessW(path_of(words[0]).c_str(), line.data(), nullptr, nullptr, TRUE,
                                        CREATE_NEW_PROCESS_GROUP, nullptr, nullptr, &start, &made);
  const DWORD error = ::GetLastError();
  close_once(input);
  if (started == 0) {
    close_once(process_->pipe);
    close_once(process_->messages);
    ::SetLastError(error);
    refuse("does not start");
  }
  ::CloseHandle(made.hThread);
  process_->id = made.hProcess;
}

PipedProgram::~PipedProgram() {
  if (process_->id != nullptr) {
    ::TerminateProcess(process_->id, 1);
    wait();
  }
  close_once(process_->messages);
}

bool PipedProgram::write(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    DWORD n = 0;
    const auto most = static_cast<DWORD>(std::min<std::size_t>(bytes.size(), 1 << 30));
    if (::WriteFile(process_->pipe, bytes.data(), most, &n, nullptr) == 0) return false;
    bytes = bytes.subspan(n);
  }
  return true;
}

std::string PipedProgram::wait() {
  close_once(process_->pipe);
  ::WaitForSingleObject(process_->id, INFINITE);
  DWORD status = 0;
  ::GetExitCodeProcess(process_->id, &status);
  close_once(process_->id);
  if (status == 0) return {};
  if (process_->messages != nullptr) {
    if (const std::string text = read_all(process_->messages); !last_line(text).empty()) {
      return std::string(last_line(text));
    }
  }
  return "exit status " + std::to_string(status);
}

}  // namespace psim::os
