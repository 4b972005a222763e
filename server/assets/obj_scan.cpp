#include "server/assets/obj_scan.h"

#include "server/assets/polygon_cut.h"
#include "server/physics/shapes/mesh.h"
#include "shared/core/files/line_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

namespace zoned::assets {

namespace {

using core::quoted;

enum class Word {
    kVertex,
    kFace,
    kStroke,  // points and lines
    kPassed,
    kFreeForm,
    kUnknown
};

constexpr std::array kPassedWords = {
    std::string_view("vt"),     std::string_view("vn"),       std::string_view("vp"),
    std::string_view("g"),      std::string_view("o"),        std::string_view("s"),
    std::string_view("mg"),     std::string_view("usemtl"),   std::string_view("mtllib"),
    std::string_view("usemap"), std::string_view("maplib"),   std::string_view("lod"),
    std::string_view("bevel"),  std::string_view("c_interp"), std::string_view("d_interp"),
    std::string_view("call"),   std::string_view("csh"),      std::string_view("shadow_obj"),
    std::string_view("ctech"),  std::string_view("stech"),    std::string_view("trace_obj")};

constexpr std::array kFreeFormWords = {
    std::string_view("cstype"), std::string_view("deg"),   std::string_view("bmat"),
    std::string_view("step"),   std::string_view("curv"),  std::string_view("curv2"),
    std::string_view("surf"),   std::string_view("parm"),  std::string_view("trim"),
    std::string_view("hole"),   std::string_view("scrv"),  std::string_view("sp"),
    std::string_view("end"),    std::string_view("con"),   std::string_view("bzp"),
    std::string_view("bsp"),    std::string_view("patch"), std::string_view("cdc"),
    std::string_view("cdp"),    std::string_view("res")};

template <std::size_t N>
bool holds(const std::array<std::string_view, N>& words, std::string_view word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

Word word_of(std::string_view token) {
    if (token.size() == 1) {
        switch (token[0]) {
            case 'v':
                return Word::kVertex;
            case 'f':
                return Word::kFace;
            case 'p':
            case 'l':
                return Word::kStroke;
            default:
                break;
        }
    }
    return holds(kPassedWords, token)     ? Word::kPassed
           : holds(kFreeFormWords, token) ? Word::kFreeForm
                                          : Word::kUnknown;
}

/// A number may begin with a plus.
template <class Number>
bool parse(std::string_view token, Number& out) {
    if (token.size() > 1 && token[0] == '+' && token[1] != '-') {
        token.remove_prefix(1);
    }
    const std::optional<Number> value = core::parse_number<Number>(token);
    out = value.value_or(out);
    return value.has_value();
}

class Scanner {
  public:
    explicit Scanner(std::string_view text) : in_(text) {}

    ObjScan run() {
        while (!full_ && in_.next()) {
            scan_line();
        }
        check_forward_names();
        if (out_.good()) {
            cut_faces();
        }
        std::sort(out_.mistakes.begin(),
                  out_.mistakes.end(),
                  [](const ObjMistake& a, const ObjMistake& b) { return a.line < b.line; });
        return std::move(out_);
    }

  private:
    [[nodiscard]] std::uint32_t line() const { return static_cast<std::uint32_t>(in_.line()); }

    void mistake(std::string text) { mistake_at(line(), std::move(text)); }

    void mistake_at(std::uint32_t line, std::string text) {
        if (++out_.mistake_count <= kMaxObjMistakes) {
            ObjMistake& mistake = out_.mistakes.emplace_back();
            mistake.line = line;
            mistake.text = std::move(text);
        }
    }

    void scan_line() {
        if (in_.rest().find('\0') != std::string_view::npos) {
            mistake("holds a zero byte: this is no text");
            return;
        }
        const std::string_view token = in_.word();
        if (token.empty() || token[0] == '#') {
            return;
        }
        if (in_.rest().ends_with('\\')) {
            mistake("goes on in the next line: lines joined by a backslash are not read");
            return;
        }
        switch (word_of(token)) {
            case Word::kVertex:
                scan_vertex();
                break;
            case Word::kFace:
                scan_face();
                break;
            case Word::kStroke:
                scan_stroke();
                break;
            case Word::kPassed:
                break;
            case Word::kFreeForm:
                mistake(quoted(token) + " is of a free-form surface; only polygons are read");
                break;
            case Word::kUnknown:
                mistake(quoted(token) + " is no word of the OBJ format");
                break;
        }
    }

    /// x y z, and a weight or a colour that nobody asks for.
    void scan_vertex() {
        // It counts even when it is wrong, so that the numbers in faces stay right.
        Vec3& at = out_.vertices.emplace_back(Vec3::Zero());
        out_.vertex_lines.push_back(line());
        int numbers = 0;
        for (std::string_view token = in_.word(); !token.empty(); token = in_.word()) {
            double value = 0.0;
            if (!parse(token, value) || !std::isfinite(value) ||
                std::abs(value) > std::numeric_limits<float>::max()) {
                mistake(quoted(token) + " is no finite number");
                return;
            }
            if (numbers < 3) {
                at[numbers] = static_cast<float>(value);
            }
            ++numbers;
        }
        if (numbers < 3) {
            mistake("a vertex has three coordinates; here are " + std::to_string(numbers));
        }
    }

    void scan_stroke() {
        const std::size_t first = corners_.size();
        scan_corners();
        corners_.resize(first);
    }

    void scan_face() {
        const std::uint64_t before = out_.mistake_count;
        const std::size_t first = corners_.size();
        const std::size_t count = scan_corners();
        if (out_.mistake_count == before && count < 3) {
            mistake("a face has three corners or more; here are " + std::to_string(count));
        } else if (out_.mistake_count == before && count > kMaxObjCorners) {
            mistake("a face of " + std::to_string(count) + " corners; at most " +
                    std::to_string(kMaxObjCorners) + ": cut it into smaller ones");
        }
        if (out_.mistake_count > 0) {
            corners_.resize(first);  // nobody will ask for them
            return;
        }
        triangles_ += count - 2;
        if (triangles_ > physics::kMaxMeshTriangles) {
            mistake("more than " + std::to_string(physics::kMaxMeshTriangles) +
                    " triangles: cut the mesh into several");
            full_ = true;
            return;
        }
        faces_.push_back({line(), static_cast<std::uint32_t>(count)});
    }

    /// Corners i, i/j, i//k, i/j/k; says how many, up to the first that is wrong.
    std::size_t scan_corners() {
        std::size_t count = 0;
        for (std::string_view token = in_.word(); !token.empty(); token = in_.word()) {
            std::string_view rest = token;
            std::int32_t vertex = 0;
            if (!scan_corner(rest, vertex)) {
                mistake(quoted(token) + " is no corner: i, i/j, i//k or i/j/k, none of them zero");
                return count;
            }
            if (!check_name(vertex)) {
                return count;
            }
            const auto known = static_cast<std::uint32_t>(out_.vertices.size());
            const auto number = static_cast<std::uint32_t>(vertex);
            corners_.push_back(vertex > 0 ? number - 1 : known + number);
            ++count;
        }
        return count;
    }

    static bool scan_corner(std::string_view token, std::int32_t& vertex) {
        for (int part = 0; part < 3; ++part) {
            const std::size_t end = std::min(token.find('/'), token.size());
            const std::string_view number = token.substr(0, end);
            std::int32_t value = 0;
            const bool left_out = part == 1 && number.empty() && end < token.size();
            if (!left_out && (!parse(number, value) || value == 0)) {
                return false;
            }
            if (part == 0) {
                vertex = value;
            }
            if (end == token.size()) {
                return true;
            }
            token.remove_prefix(end + 1);
        }
        return false;
    }

    /// Names from the front may come before their vertex: the largest of each line is
    /// looked at in the end.
    bool check_name(std::int32_t vertex) {
        const auto known = static_cast<std::int64_t>(out_.vertices.size());
        if (vertex < 0 && -static_cast<std::int64_t>(vertex) > known) {
            mistake("names vertex " + std::to_string(vertex) + " where there are " +
                    std::to_string(known) + " so far");
            return false;
        }
        if (vertex > known) {
            if (forward_.empty() || forward_.back().line != line()) {
                forward_.push_back({line(), vertex});
            }
            forward_.back().vertex = std::max(forward_.back().vertex, vertex);
        }
        return true;
    }

    void check_forward_names() {
        for (const Name& name : forward_) {
            if (static_cast<std::size_t>(name.vertex) > out_.vertices.size()) {
                mistake_at(name.line,
                           "names vertex " + std::to_string(name.vertex) + " of " +
                               std::to_string(out_.vertices.size()));
            }
        }
    }

    void cut_faces() {
        out_.faces = static_cast<std::uint32_t>(faces_.size());
        out_.indices.reserve(3 * triangles_);
        out_.triangle_lines.reserve(triangles_);
        std::vector<Vec3> points;
        std::vector<std::array<std::uint32_t, 3>> cut;
        std::span<const std::uint32_t> rest(corners_);
        for (const Face& face : faces_) {
            const std::span<const std::uint32_t> corners = rest.first(face.corners);
            rest = rest.subspan(face.corners);
            points.clear();
            cut.clear();
            for (const std::uint32_t corner : corners) {
                points.push_back(out_.vertices[corner]);
            }
            if (!cut_polygon(points, cut)) {
                mistake_at(face.line, "the outline of the face crosses itself");
                continue;
            }
            for (const auto& triangle : cut) {
                for (const std::uint32_t corner : triangle) {
                    out_.indices.push_back(corners[corner]);
                }
                out_.triangle_lines.push_back(face.line);
            }
        }
    }

    struct Face {
        std::uint32_t line;
        std::uint32_t corners;
    };

    struct Name {
        std::uint32_t line;
        std::int32_t vertex;
    };

    core::LineReader in_;
    bool full_ = false;  // more triangles than a mesh may have: the rest is not read
    std::vector<Name> forward_;
    std::vector<Face> faces_;
    std::vector<std::uint32_t> corners_;  // of the faces, one after the other
    std::uint64_t triangles_ = 0;
    ObjScan out_;
};

}  // namespace

ObjScan scan_obj(std::string_view text) {
    return Scanner(text).run();
}

}  // namespace zoned::assets
