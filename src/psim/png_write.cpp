#include "png_write.h"

#include <png.h>

#include <string>
#include <string_view>

#include "user_error.h"

namespace psim::cli {
namespace {

[[noreturn]] void on_error(png_structp, png_const_charp message) {
  throw UserError(std::string("PNG: ") + message);
}

void on_warning(png_structp, png_const_charp) {}

void on_data(png_structp png, png_bytep data, png_size_t size) {
  auto* const file = static_cast<AtomicFile*>(png_get_io_ptr(png));
  file->write(std::string_view(reinterpret_cast<const char*>(data), size));
}

void on_flush(png_structp) {}

// Frees libpng's two structures on every way out.
struct Writer {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  Writer() = default;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer() { png_destroy_write_struct(&png, &info); }
};

}  // namespace

void write_png(AtomicFile& file, int width, int height, std::span<const std::uint8_t> rgb) {
  // The quickest of those tried on pictures of discs (docs/pictures.md): filters cost more than they save.
  constexpr int kFastest = 1;
  constexpr std::size_t kBufferBytes = 1 << 16;
  Writer writer;
  if (writer.info == nullptr) throw UserError("PNG: out of memory");
  png_set_write_fn(writer.png, &file, on_data, on_flush);
  png_set_compression_level(writer.png, kFastest);
  png_set_filter(writer.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
  png_set_compression_buffer_size(writer.png, kBufferBytes);
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(width),
               static_cast<png_uint_32>(height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(writer.png, writer.info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(writer.png, writer.info);
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(width);
  for (int row = 0; row < height; ++row) {
    png_write_row(writer.png, rgb.data() + row_bytes * static_cast<std::size_t>(row));
  }
  png_write_end(writer.png, writer.info);
}

}  // namespace psim::cli
