// Bake report: the output of `zoned bake` for a geometry file.
#pragma once

#include "server/assets/geometry_survey.h"
#include "server/assets/obj_scan.h"
#include "server/physics/shapes/mesh.h"

#include <string>
#include <vector>

namespace zoned::app {

/// Lines "  name  figures", the names padded to one width.
class BakeReport {
  public:
    /// Text formatted as by printf.
    [[gnu::format(printf, 3, 4)]] void row(const char* name, const char* format, ...);

    [[nodiscard]] const std::string& text() const { return text_; }

  private:
    std::string text_;
};

/// The findings of the mesh build; `lines` of the vertices in the OBJ.
void report_build(const assets::ObjScan& scan, const physics::BuiltMesh& built, BakeReport& report);
void report_mesh(const assets::MeshSurvey& mesh, BakeReport& report);
void report_field(const assets::FieldSurvey& field, BakeReport& report);

}  // namespace zoned::app
