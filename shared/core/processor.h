// Processor check: ends the program early where the processor lacks instructions that the program
// was built for.
#pragma once

namespace zoned::core {

/// Exits with code 3 and a clear line on standard error when the program was built for x86-64-v3
/// and the processor lacks it. Runs by itself before main() in every program that calls it once.
void require_processor();

}  // namespace zoned::core
