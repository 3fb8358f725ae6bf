#include "picture/image.h"

#include <cstdint>
#include <vector>

#include "picture/painter.h"
#include "picture/png_write.h"

namespace psim::cli {

void write_image(AtomicFile& file, const Scene& scene, const Moment& moment, const PictureOptions& options,
                 int threads) {
  constexpr int kLongSide = 1600;  // pixels
  const Painter painter(scene, options);
  const Bounds view = options.view.value_or(view_of_all(scene, moment, painter.shapes()));
  const PictureSize size = options.size.value_or(size_for(view, kLongSide));
  Canvas canvas(size.width, size.height);
  painter.paint(canvas, PictureCamera(view, size.width, size.height), moment,
                brightest(scene, moment, painter.shapes()));
  std::vector<std::uint8_t> rgb;
  canvas.to_srgb(rgb, threads);
  write_png(file, size.width, size.height, rgb, threads);
}

}  // namespace psim::cli
