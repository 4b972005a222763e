// FormationDef: the shape of a formation around a captain.
#pragma once

#include "server/ai/crowd/formation.h"

#include <cstddef>
#include <cstdint>

namespace zoned::ai {

enum class FormationShape : std::uint8_t {
    kRows,   ///< `columns` abreast, row behind row
    kWedge,  ///< two behind the captain, then three, then four
    kRing    ///< all around the captain, evenly
};

/// Further members have no slots: they walk with the captain.
inline constexpr std::size_t kMostInFormation = 120;

struct FormationDef {
    FormationShape shape = FormationShape::kRows;
    std::uint16_t columns = 4;  ///< of kRows, > 0
    float spacing_m = 1.5F;     ///< between neighbours, and between the captain and the first row
    steering::FormationSettings settings{};
};

}  // namespace zoned::ai
