// Makes a picture of a look, with progress, and shows what a faulty document says.
//
//     c++ -std=c++17 picture.cpp -o picture $(pkg-config --cflags --libs trochoid)
//     ./picture water.json > picture.ppm
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>
#include "trochoid.h"

namespace {

struct Release {
  void operator()(const trochoid_look *look) const { trochoid_look_release(look); }
  void operator()(trochoid_error *error) const { trochoid_error_release(error); }
};
using Look = std::unique_ptr<const trochoid_look, Release>;
using Error = std::unique_ptr<trochoid_error, Release>;

// Turns a status with its error into an exception.
void check(trochoid_status status, trochoid_error *error) {
  Error owner(error);
  if (status != TROCHOID_OK) throw std::runtime_error(trochoid_error_text(error));
}

Look open(const std::string &path, const std::vector<const char *> &inputs,
          const std::vector<const char *> &assignments = {}) {
  trochoid_options options;
  trochoid_options_init(&options, sizeof options);
  options.inputs = inputs.data();
  options.input_count = inputs.size();
  options.assignments = assignments.data();
  options.assignment_count = assignments.size();
  const trochoid_look *look = nullptr;
  trochoid_error *error = nullptr;
  const trochoid_status status = trochoid_look_open(path.c_str(), &options, &look, &error);
  check(status, error);
  return Look(look);
}

}  // namespace

int main(int argc, char **argv) try {
  if (argc != 2) throw std::runtime_error("usage: picture DOCUMENT");
  try {
    open(argv[1], {"light", "rim"}, {"water.weight=lihgt"});
    return 1;
  } catch (const std::runtime_error &error) {
    std::fprintf(stderr, "as it should be, %s\n", error.what());
  }

  const Look look = open(argv[1], {"light", "rim"});
  constexpr std::uint32_t width = 320, height = 180;
  constexpr std::size_t area = std::size_t(width) * height;
  std::vector<float> light(area), rim(area), rgb(3 * area);
  for (std::size_t i = 0; i < area; i++) {
    const float x = float(i % width) / (width - 1), y = float(i / width) / (height - 1);
    light[i] = 0.5f + 0.5f * std::sin(9 * x + 4 * y);
    rim[i] = y * y * y;
  }
  const trochoid_in in[] = {{light.data(), 4}, {rim.data(), 4}};
  const trochoid_out out[] = {{rgb.data(), 12}, {rgb.data() + 1, 12}, {rgb.data() + 2, 12}};
  const auto progress = [](std::size_t done, std::size_t total, void *) -> std::int32_t {
    if (done == total) std::fprintf(stderr, "%zu tiles\n", total);
    return 0;
  };
  trochoid_report report{};
  report.struct_size = sizeof report;
  trochoid_error *error = nullptr;
  const trochoid_status status =
      trochoid_picture(look.get(), width, height, in, out, progress, nullptr, &report, &error);
  check(status, error);
  std::fprintf(stderr, "%llu pixels, %llu outside of the palette of %llu colors\n",
               (unsigned long long)report.pixels, (unsigned long long)report.hull_exits,
               (unsigned long long)report.control_count);
  std::printf("P6\n%u %u\n255\n", width, height);
  for (const float value : rgb) std::putchar(int(std::lround(255 * value)));
  return 0;
} catch (const std::exception &error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
