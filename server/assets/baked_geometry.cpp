#include "server/assets/baked_geometry.h"

#include <openssl/evp.h>

#include <bit>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

namespace zoned::assets {

namespace {

using core::Result;
using physics::Heightfield;
using physics::Shape;
using physics::TriangleMesh;

// Tables are written as they lie in memory.
static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(Vec3) == 12 && sizeof(physics::EdgeBend) == 8);

enum Kind : std::uint32_t {
    kMeshKind = 1,
    kFieldKind = 2
};

constexpr std::size_t kMeshHead = 16;
constexpr std::size_t kFieldHead = 20;

template <class T>
void put(const T& value, std::string& out) {
    out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <class T>
void put_table(const std::vector<T>& table, std::string& out) {
    out.append(reinterpret_cast<const char*>(table.data()), table.size() * sizeof(T));
}

template <class T>
T take(std::string_view& bytes) {
    T value;
    std::memcpy(&value, bytes.data(), sizeof(T));
    bytes.remove_prefix(sizeof(T));
    return value;
}

/// `bytes` are known to hold the table.
template <class T>
std::vector<T> take_table(std::size_t count, std::string_view& bytes) {
    std::vector<T> table(count);
    if (count > 0) {
        std::memcpy(static_cast<void*>(table.data()), bytes.data(), count * sizeof(T));
    }
    bytes.remove_prefix(count * sizeof(T));
    return table;
}

using Sum = std::array<unsigned char, 32>;

/// Of a whole file but for the place of the sum.
Sum sum_of(std::string_view file) {
    Sum sum{};
    EVP_MD_CTX* context = EVP_MD_CTX_new();
    const std::string_view head = file.substr(0, kBakedSumAt);
    const std::string_view body = file.substr(kBakedBodyAt);
    const bool done = context != nullptr &&
                      EVP_DigestInit_ex(context, EVP_sha256(), nullptr) == 1 &&
                      EVP_DigestUpdate(context, head.data(), head.size()) == 1 &&
                      EVP_DigestUpdate(context, body.data(), body.size()) == 1 &&
                      EVP_DigestFinal_ex(context, sum.data(), nullptr) == 1;
    EVP_MD_CTX_free(context);
    ZONED_ASSERT(done, "SHA-256 is part of every OpenSSL");
    return sum;
}

std::string head_of(Kind kind, std::size_t body) {
    std::string out(kBakedMagic.begin(), kBakedMagic.end());
    out.reserve(kBakedBodyAt + body);
    put(kBakedVersion, out);
    put(static_cast<std::uint32_t>(kind), out);
    put(static_cast<std::uint64_t>(body), out);
    out.append(kBakedBodyAt - kBakedSumAt, '\0');
    return out;
}

/// Bytes of the body of a mesh. Counts are below 2^32, so that nothing overflows.
std::uint64_t mesh_bytes(std::uint64_t vertices, std::uint64_t triangles, std::uint64_t nodes) {
    return kMeshHead + 12 * vertices + (12 + 24 + 4) * triangles + nodes;
}

Result<Shape> read_mesh(std::string_view body) {
    if (body.size() < kMeshHead) {
        return Result<Shape>::failure("mesh: the body ends within the counts");
    }
    const std::size_t all = body.size();
    const auto vertices = take<std::uint32_t>(body);
    const auto triangles = take<std::uint32_t>(body);
    const auto nodes = take<std::uint32_t>(body);
    if (take<std::uint32_t>(body) != 0) {
        return Result<Shape>::failure("mesh: a reserved field is not zero");
    }
    if (mesh_bytes(vertices, triangles, nodes) != all) {
        return Result<Shape>::failure("mesh: " + std::to_string(vertices) + " vertices, " +
                                      std::to_string(triangles) + " triangles and " +
                                      std::to_string(nodes) + " nodes take " +
                                      std::to_string(mesh_bytes(vertices, triangles, nodes)) +
                                      " bytes, the body has " + std::to_string(all));
    }
    physics::MeshParts parts;
    parts.vertices = take_table<Vec3>(vertices, body);
    parts.corners = take_table<std::array<std::uint32_t, 3>>(triangles, body);
    parts.bends = take_table<std::array<physics::EdgeBend, 3>>(triangles, body);
    parts.tree.order = take_table<std::uint32_t>(triangles, body);
    parts.tree.nodes = take_table<std::uint8_t>(nodes, body);
    auto mesh = physics::restore_mesh(std::move(parts));
    if (!mesh) {
        return Result<Shape>::failure(mesh.error());
    }
    return Shape::mesh(std::move(*mesh));
}

Result<Shape> read_field(std::string_view body) {
    if (body.size() < kFieldHead) {
        return Result<Shape>::failure("heightfield: the body ends within the sizes");
    }
    const std::uint64_t all = body.size();
    physics::FieldOptions options;
    options.columns = take<std::uint32_t>(body);
    options.rows = take<std::uint32_t>(body);
    options.spacing_x = take<float>(body);
    options.spacing_z = take<float>(body);
    options.thickness = take<float>(body);
    // Minus zero: adding it changes no bit of a height, plus zero would.
    options.offset = -0.0F;
    const std::uint64_t samples = std::uint64_t{options.columns} * options.rows;
    if (samples > all || kFieldHead + 4 * samples != all) {
        return Result<Shape>::failure("heightfield: " + std::to_string(options.columns) + " x " +
                                      std::to_string(options.rows) +
                                      " heights do not fill a body of " + std::to_string(all) +
                                      " bytes");
    }
    auto field = physics::build_heightfield(take_table<float>(samples, body), options);
    if (!field) {
        return Result<Shape>::failure(field.error());
    }
    return Shape::heightfield(std::move(*field));
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

template <class T>
bool same_bits(const T& a, const T& b) {
    return std::memcmp(&a, &b, sizeof(T)) == 0;
}

std::string mesh_difference(const TriangleMesh::MeshTables& a, const TriangleMesh::MeshTables& b) {
    const std::pair<bool, const char*> tables[] = {
        {same_bits(a.vertices, b.vertices), "vertices"},
        {same_bits(a.corners, b.corners), "corners"},
        {same_bits(a.normals, b.normals), "normals"},
        {same_bits(a.bends, b.bends), "bends"},
        {a.tree.same_as(b.tree), "tree"},
    };
    for (const auto& [same, name] : tables) {
        if (!same) {
            return name;
        }
    }
    return {};
}

std::string field_difference(const Heightfield::HeightfieldTables& a,
                             const Heightfield::HeightfieldTables& b) {
    if (a.columns != b.columns || a.rows != b.rows) {
        return "columns and rows";
    }
    const bool sizes = same_bits(a.spacing_x, b.spacing_x) && same_bits(a.spacing_z, b.spacing_z) &&
                       same_bits(a.thickness, b.thickness) && same_bits(a.lowest, b.lowest) &&
                       same_bits(a.highest, b.highest);
    if (!sizes) {
        return "sizes";
    }
    return same_bits(a.heights, b.heights) ? "" : "heights";
}

}  // namespace

std::string bake(const TriangleMesh& mesh) {
    const TriangleMesh::MeshTables& t = mesh.tables();
    const physics::BoxTree::Layout tree = t.tree.layout();
    std::string out =
        head_of(kMeshKind, mesh_bytes(t.vertices.size(), t.corners.size(), tree.nodes.size()));
    put(static_cast<std::uint32_t>(t.vertices.size()), out);
    put(static_cast<std::uint32_t>(t.corners.size()), out);
    put(static_cast<std::uint32_t>(tree.nodes.size()), out);
    put(std::uint32_t{0}, out);
    put_table(t.vertices, out);
    put_table(t.corners, out);
    put_table(t.bends, out);
    put_table(tree.order, out);
    put_table(tree.nodes, out);
    seal_baked(out);
    return out;
}

std::string bake(const Heightfield& field) {
    const Heightfield::HeightfieldTables& t = field.tables();
    std::string out = head_of(kFieldKind, kFieldHead + 4 * t.heights.size());
    put(t.columns, out);
    put(t.rows, out);
    put(t.spacing_x, out);
    put(t.spacing_z, out);
    put(t.thickness, out);
    put_table(t.heights, out);
    seal_baked(out);
    return out;
}

std::string bake(const Shape& shape) {
    ZONED_ASSERT(
        shape.kind == physics::ShapeKind::kMesh || shape.kind == physics::ShapeKind::kHeightfield,
        "only surfaces are baked");
    return shape.kind == physics::ShapeKind::kMesh ? bake(mesh_of(shape)) : bake(field_of(shape));
}

void seal_baked(std::string& bytes) {
    ZONED_ASSERT(bytes.size() >= kBakedBodyAt, "a baked file has a head");
    const Sum sum = sum_of(bytes);
    std::memcpy(bytes.data() + kBakedSumAt, sum.data(), sum.size());
}

bool is_baked(std::string_view bytes) {
    return bytes.substr(0, kBakedMagic.size()) ==
           std::string_view(kBakedMagic.data(), kBakedMagic.size());
}

Result<Shape> read_baked(std::string_view bytes) {
    if (!is_baked(bytes)) {
        return Result<Shape>::failure("baked: does not begin with ZONEDGEO");
    }
    if (bytes.size() < kBakedBodyAt) {
        return Result<Shape>::failure("baked: ends within the head");
    }
    std::string_view head = bytes.substr(kBakedMagic.size());
    const auto version = take<std::uint32_t>(head);
    const auto kind = take<std::uint32_t>(head);
    const auto length = take<std::uint64_t>(head);
    if (version != kBakedVersion) {
        return Result<Shape>::failure("baked: is of version " + std::to_string(version) +
                                      ", this program reads version " +
                                      std::to_string(kBakedVersion) + ": bake the source again");
    }
    const std::string_view body = bytes.substr(kBakedBodyAt);
    if (length != body.size()) {
        return Result<Shape>::failure("baked: the body has " + std::to_string(body.size()) +
                                      " bytes instead of " + std::to_string(length) +
                                      ": cut short or written over");
    }
    const Sum sum = sum_of(bytes);
    if (std::memcmp(sum.data(), bytes.data() + kBakedSumAt, sum.size()) != 0) {
        return Result<Shape>::failure("baked: the checksum does not fit: the file is damaged");
    }
    if (kind != kMeshKind && kind != kFieldKind) {
        return Result<Shape>::failure("baked: holds kind " + std::to_string(kind) +
                                      " instead of 1 (mesh) or 2 (heightfield)");
    }
    return kind == kMeshKind ? read_mesh(body) : read_field(body);
}

std::string difference_of(const Shape& a, const Shape& b) {
    if (a.kind != b.kind) {
        return "kind";
    }
    return a.kind == physics::ShapeKind::kMesh
               ? mesh_difference(mesh_of(a).tables(), mesh_of(b).tables())
               : field_difference(field_of(a).tables(), field_of(b).tables());
}

}  // namespace zoned::assets
