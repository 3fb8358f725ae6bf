#include "output/atomic_file.h"

#include <fmt/format.h>

#include <cstring>

#include "base/output_file.h"
#include "output/text.h"
#include "output/user_error.h"

namespace psim::cli {

AtomicFile::AtomicFile(std::string_view option, const std::string& path)
    : label_(fmt::format("{} {}", option, one_line(path))), file_(std::make_unique<OutputFile>(path)) {
  if (file_->error() != 0) refuse();
}

AtomicFile::~AtomicFile() = default;

void AtomicFile::refuse() const {
  throw UserError(fmt::format("{}: cannot be written: {}", label_, std::strerror(file_->error())));
}

int AtomicFile::descriptor() const { return file_->descriptor(); }
std::string AtomicFile::path_for_program(int there) { return file_->path_for_program(there); }

void AtomicFile::flush() {
  file_->write(buffer_.data(), buffer_.size());
  buffer_.clear();
}

void AtomicFile::commit(Durable durable) {
  flush();
  if (!file_->commit(durable == Durable::yes)) refuse();
}

}  // namespace psim::cli
