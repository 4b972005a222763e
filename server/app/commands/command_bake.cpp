#include "server/app/commands/bake_report.h"
#include "server/app/commands/commands.h"
#include "server/app/runtime/tick_loop.h"
#include "server/assets/baked_geometry.h"
#include "server/assets/geometry_files.h"
#include "server/assets/geometry_survey.h"

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>
#include <system_error>
#include <utility>

namespace zoned::app {

namespace {

using physics::Shape;

/// CPU time of this thread since its construction. Other load on the machine does not count.
class CpuStopwatch {
  public:
    [[nodiscard]] double ms() const {
        return static_cast<double>(thread_cpu_ns() - begin_) / 1.0e6;
    }

  private:
    std::uint64_t begin_ = thread_cpu_ns();
};

/// The state of the file so far.
struct Work {
    const BakeArguments& arguments;
    std::string bytes;
    Shape shape;
    double ms = 0.0;  ///< from bytes to a shape
    BakeReport report;
    std::vector<std::string> warnings;
};

int complain(const Work& work, const std::string& text) {
    std::fprintf(stderr, "%s: %s\n", work.arguments.file.c_str(), text.c_str());
    return kUsage;
}

/// An option that was given and that the content of the file has no use for.
const char* misplaced_option(const BakeArguments& a, assets::GeometryContent content) {
    const bool text = content == assets::GeometryContent::kText;
    const bool png = content == assets::GeometryContent::kPng;
    const std::pair<bool, const char*> options[] = {
        {a.scale.has_value() && !text, "--scale belongs to OBJ files"},
        {a.weld.has_value() && !text, "--weld belongs to OBJ files"},
        {a.height.has_value() && !png, "--height belongs to PNG images"},
        {a.spacing.has_value() && !png, "--spacing belongs to PNG images"},
        {a.offset.has_value() && !png, "--offset belongs to PNG images"},
        {a.thickness.has_value() && !png, "--thickness belongs to PNG images"},
    };
    for (const auto& [misplaced, text_of] : options) {
        if (misplaced) {
            return text_of;
        }
    }
    return nullptr;
}

int complain_of_lines(const Work& work, const assets::ObjScan& scan) {
    const char* file = work.arguments.file.c_str();
    for (const assets::ObjMistake& mistake : scan.mistakes) {
        std::fprintf(stderr, "%s:%u: %s\n", file, mistake.line, mistake.text.c_str());
    }
    std::fprintf(stderr,
                 "zoned: %llu mistake%s in %s; nothing was written\n",
                 static_cast<unsigned long long>(scan.mistake_count),
                 scan.mistake_count == 1 ? "" : "s",
                 file);
    return kUsage;
}

void survey_mesh(Work& work) {
    const assets::MeshSurvey figures =
        assets::survey(physics::mesh_of(work.shape), work.arguments.error_budget_m);
    report_mesh(figures, work.report);
    work.warnings = assets::stability_warnings_of(figures, work.arguments.error_budget_m);
}

void survey_field(float level_m, Work& work) {
    const assets::FieldSurvey figures = assets::survey(physics::field_of(work.shape));
    report_field(figures, work.report);
    work.warnings = assets::stability_warnings_of(figures, level_m, work.arguments.error_budget_m);
}

int read_obj(Work& work) {
    const CpuStopwatch watch;
    const assets::ObjScan scan = assets::scan_obj(work.bytes);
    if (!scan.good()) {
        return complain_of_lines(work, scan);
    }
    const physics::MeshOptions options{work.arguments.weld.value_or(0.0F)};
    const auto built =
        assets::mesh_from_scanned(scan, work.arguments.scale.value_or(1.0F), options);
    work.ms = watch.ms();
    if (!built) {
        return complain(work, built.error());
    }
    work.shape = Shape::mesh(built->mesh);
    report_build(scan, *built, work.report);
    survey_mesh(work);
    return kGood;
}

int read_png(Work& work) {
    const BakeArguments& a = work.arguments;
    if (!a.height) {
        return complain(work, "an image does not say how high white is: give --height METRES");
    }
    const CpuStopwatch watch;
    physics::FieldOptions options;
    options.spacing_x = options.spacing_z = a.spacing.value_or(1.0F);
    options.offset = a.offset.value_or(0.0F);
    options.thickness = a.thickness.value_or(1.0F);
    auto field =
        assets::heightfield_from_png(std::as_bytes(std::span(work.bytes)), *a.height, options);
    work.ms = watch.ms();
    if (!field) {
        return complain(work, field.error());
    }
    work.shape = Shape::heightfield(std::move(*field));
    const unsigned bits = assets::png_bits(work.bytes);
    const float level = std::abs(*a.height) / static_cast<float>((1U << bits) - 1U);
    work.report.row("levels", "%u bits, %g m each", bits, static_cast<double>(level));
    survey_field(level, work);
    return kGood;
}

/// A mesh is also built anew from its triangles: the edges of an undamaged file may still
/// contradict its triangles.
int check_built_anew(Work& work) {
    const physics::TriangleMesh::MeshTables& t = physics::mesh_of(work.shape).tables();
    std::vector<std::uint32_t> indices;
    indices.reserve(3 * t.corners.size());
    for (const auto& corners : t.corners) {
        indices.insert(indices.end(), corners.begin(), corners.end());
    }
    const CpuStopwatch watch;
    const auto built = physics::build_mesh(t.vertices, indices);
    const double ms = watch.ms();
    const std::string difference =
        built ? assets::difference_of(work.shape, Shape::mesh(built->mesh)) : built.error();
    if (!difference.empty()) {
        return complain(work, "is not what its triangles give when they are baked: " + difference);
    }
    work.report.row("built anew", "the same, in %.3g ms (CPU)", ms);
    return kGood;
}

int read_baked(Work& work) {
    if (!work.arguments.check) {
        return complain(work, "is baked already; --check checks it");
    }
    const CpuStopwatch watch;
    auto shape = assets::read_baked(work.bytes);
    work.ms = watch.ms();
    if (!shape) {
        return complain(work, shape.error());
    }
    work.shape = std::move(*shape);
    if (work.shape.kind == physics::ShapeKind::kHeightfield) {
        survey_field(0.0F, work);
        return kGood;
    }
    survey_mesh(work);
    return check_built_anew(work);
}

int read_source(assets::GeometryContent content, Work& work) {
    switch (content) {
        case assets::GeometryContent::kPng:
            return read_png(work);
        case assets::GeometryContent::kBaked:
            return read_baked(work);
        case assets::GeometryContent::kText:
            return read_obj(work);
        case assets::GeometryContent::kUnknown:
            break;
    }
    return complain(work, "is no PNG image, no OBJ text and no baked file");
}

const char* name_of(assets::GeometryContent content) {
    return content == assets::GeometryContent::kPng     ? "PNG image"
           : content == assets::GeometryContent::kBaked ? "baked file, checksum good"
                                                        : "OBJ text";
}

/// Under another name first, so that nobody ever reads half of it.
void write_file(const std::string& path, const std::string& bytes) {
    const std::string half = path + ".part";
    std::ofstream out(half, std::ios::binary | std::ios::trunc);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) {
        const int reason = errno;
        std::error_code ignored;
        std::filesystem::remove(half, ignored);
        throw std::system_error(reason, std::generic_category(), "cannot write " + path);
    }
    std::filesystem::rename(half, path);
}

/// Bakes, reads back and compares before anything is written.
int bake_and_write(Work& work) {
    const std::string baked = assets::bake(work.shape);
    const CpuStopwatch watch;
    const auto again = assets::read_baked(baked);
    const double ms = watch.ms();
    const std::string difference =
        again ? assets::difference_of(work.shape, *again) : again.error();
    work.report.row("time",
                    "%.3g ms from this file, %.3g ms from the baked one, %.1f times as fast (CPU)",
                    work.ms,
                    ms,
                    work.ms / ms);
    work.report.row("baked", "%zu bytes, read back and compared", baked.size());
    std::fputs(work.report.text().c_str(), stdout);
    if (!difference.empty()) {
        std::fprintf(stderr,
                     "zoned: %s: what was baked reads back differently: %s; nothing was written\n",
                     work.arguments.file.c_str(),
                     difference.c_str());
        return kFailed;
    }
    if (work.arguments.check) {
        return kGood;
    }
    const std::string out =
        work.arguments.out.empty() ? work.arguments.file + ".baked" : work.arguments.out;
    std::error_code none;
    if (std::filesystem::equivalent(out, work.arguments.file, none)) {
        return complain(work, "--out would overwrite it");
    }
    write_file(out, baked);
    std::printf("wrote %s\n", out.c_str());
    return kGood;
}

}  // namespace

int bake(const BakeArguments& arguments) {
    auto bytes = assets::read_geometry_file(arguments.file);
    if (!bytes) {
        std::fprintf(stderr, "zoned: %s\n", bytes.error().c_str());
        return kEnvironment;
    }
    Work work{arguments, std::move(*bytes), {}, 0.0, {}, {}};
    const assets::GeometryContent content = assets::content_of(work.bytes);
    if (const char* misplaced = misplaced_option(arguments, content)) {
        return complain(work, misplaced);
    }
    if (const int code = read_source(content, work); code != kGood) {
        return code;
    }
    std::printf("%s: %s, %zu bytes\n", arguments.file.c_str(), name_of(content), work.bytes.size());
    int code = kGood;
    if (content == assets::GeometryContent::kBaked) {
        work.report.row("time", "%.3g ms (CPU)", work.ms);
        std::fputs(work.report.text().c_str(), stdout);
    } else {
        code = bake_and_write(work);
    }
    for (const std::string& warning : work.warnings) {
        std::printf("%s: warning: %s\n", arguments.file.c_str(), warning.c_str());
    }
    return code;
}

}  // namespace zoned::app
