#include "server/app/commands/bake_report.h"

#include <array>
#include <cstdarg>
#include <cstdio>

namespace zoned::app {

namespace {

/// " (first: vertices of lines 3, 4)", or nothing when there is none.
std::string first_edge(std::uint32_t count,
                       const std::array<std::uint32_t, 2>& vertices,
                       const assets::ObjScan& scan) {
    return count == 0
               ? std::string()
               : " (first: vertices of lines " + std::to_string(scan.vertex_lines[vertices[0]]) +
                     ", " + std::to_string(scan.vertex_lines[vertices[1]]) + ")";
}

std::string first_face(std::uint32_t count, std::uint32_t triangle, const assets::ObjScan& scan) {
    return count == 0
               ? std::string()
               : " (first: face of line " + std::to_string(scan.triangle_lines[triangle]) + ")";
}

void report_size(const Aabb& box, BakeReport& report) {
    const Vec3 size = box.upper - box.lower;
    report.row("size",
               "%g x %g x %g m, from (%g, %g, %g) to (%g, %g, %g)",
               static_cast<double>(size.x()),
               static_cast<double>(size.y()),
               static_cast<double>(size.z()),
               static_cast<double>(box.lower.x()),
               static_cast<double>(box.lower.y()),
               static_cast<double>(box.lower.z()),
               static_cast<double>(box.upper.x()),
               static_cast<double>(box.upper.y()),
               static_cast<double>(box.upper.z()));
}

}  // namespace

void BakeReport::row(const char* name, const char* format, ...) {
    char line[400];
    std::va_list values;
    va_start(values, format);
    std::vsnprintf(line, sizeof(line), format, values);
    va_end(values);
    char head[40];
    std::snprintf(head, sizeof(head), "  %-18s ", name);
    text_ += head;
    text_ += line;
    text_ += '\n';
}

void report_build(const assets::ObjScan& scan,
                  const physics::BuiltMesh& built,
                  BakeReport& report) {
    report.row("faces", "%u, cut into %zu triangles", scan.faces, scan.triangle_lines.size());
    report.row("degenerate",
               "%u without area, left out%s",
               built.degenerate,
               first_face(built.degenerate, built.first_degenerate, scan).c_str());
    report.row("repeated",
               "%u that are there already, left out%s",
               built.repeated,
               first_face(built.repeated, built.first_repeated, scan).c_str());
    report.row("merged vertices",
               "%u of %zu; %u that no face names left out",
               built.merged,
               scan.vertices.size(),
               built.unused);
    report.row("open edges",
               "%u of one triangle only%s",
               built.open_edges,
               first_edge(built.open_edges, built.first_open, scan).c_str());
    report.row("shared edges",
               "%u of more than two triangles%s",
               built.shared_edges,
               first_edge(built.shared_edges, built.first_shared, scan).c_str());
    report.row("flipped neighbours",
               "%u edges whose two triangles face opposite ways%s",
               built.turned_edges,
               first_edge(built.turned_edges, built.first_turned, scan).c_str());
}

void report_mesh(const assets::MeshSurvey& mesh, BakeReport& report) {
    report.row("triangles", "%u", mesh.triangles);
    report.row("vertices", "%u", mesh.vertices);
    report_size(mesh.box, report);
    report.row("edges",
               "%g to %g m",
               static_cast<double>(mesh.shortest_edge),
               static_cast<double>(mesh.longest_edge));
    if (mesh.looked < mesh.triangles) {
        report.row("looked behind", "%u triangles, a sample: all would take too long", mesh.looked);
    }
    report.row("tree", "%zu levels, %zu nodes", mesh.depth, mesh.nodes);
    report.row("memory", "%zu bytes", mesh.bytes);
}

void report_field(const assets::FieldSurvey& field, BakeReport& report) {
    report.row("samples", "%u x %u", field.columns, field.rows);
    report.row("triangles", "%llu", 2ULL * (field.columns - 1ULL) * (field.rows - 1ULL));
    report_size(field.box, report);
    report.row("spacing",
               "%g x %g m",
               static_cast<double>(field.spacing_x),
               static_cast<double>(field.spacing_z));
    report.row("thickness", "%g m below the lowest sample", static_cast<double>(field.thickness));
    report.row("steepest",
               "%.1f degrees, at the pixel of column %u, row %u",
               static_cast<double>(field.steepest_deg),
               field.steepest_i,
               field.steepest_k);
    report.row("tree", "none: cells are found by their place");
    report.row("memory", "%zu bytes", field.bytes);
}

}  // namespace zoned::app
