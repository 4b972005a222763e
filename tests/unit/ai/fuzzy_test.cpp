#include "server/ai/decision/fuzzy/fuzzy_state_machine.h"
#include "server/ai/decision/fuzzy/fuzzy_system.h"
#include "tests/scenario/brave.h"
#include "tests/unit/allocation_count.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace zoned::ai::fuzzy::test {
namespace {

using scenario::brave_def;
using testing::ElementsAre;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
/// Degrees and sums of a few dozen floats below 1: some roundings of 2^-24 each.
constexpr float kRounding = 1e-5F;

float evaluate(const FuzzyDef& def, const std::vector<float>& in) {
    const FuzzySystem system(def);
    float out = kNan;
    system.evaluate(in, {&out, 1});
    return out;
}

double trapezoid(const Term& t, double x) {
    if (x < static_cast<double>(t.a) || x > static_cast<double>(t.d)) {
        return 0.0;
    }
    const auto a = static_cast<double>(t.a);
    const auto b = static_cast<double>(t.b);
    const auto c = static_cast<double>(t.c);
    const auto d = static_cast<double>(t.d);
    if (x < b) {
        return std::isinf(a) ? 1.0 : (x - a) / (b - a);
    }
    return x <= c ? 1.0 : std::isinf(d) ? 1.0 : (d - x) / (d - c);
}

TEST(Membership, IsTheTrapezoid) {
    for (const Term& term : {Term{"t", 1, 2, 3, 5},
                             Term{"triangle", 1, 2, 2, 5},
                             Term{"left", -kInfinity, 2, 2, 5},
                             Term{"right", 1, 2, 2, kInfinity},
                             Term{"upright", 2, 2, 3, 3}}) {
        for (float x = -1.0F; x < 7.0F; x += 0.125F) {
            EXPECT_NEAR(degree(flat(term), x), trapezoid(term, static_cast<double>(x)), 1e-6)
                << term.name << " " << x;
        }
    }
}

/// One input with two terms that share the range: the degrees are 1 - x and x.
FuzzyDef line_def() {
    FuzzyDef def;
    def.inputs = {{"x", 0, 1, {{"low", -kInfinity, 0, 0, 1}, {"high", 0, 1, 1, kInfinity}}}};
    FuzzyOutput out;
    out.name = "y";
    out.low = -10;
    out.high = 10;
    out.values = {{"a", 3, {}}, {"b", -5, {}}};
    def.outputs = {out};
    def.rules = {{{{0, 0, false}}, false, 0, 0, 1.0F}, {{{0, 1, false}}, false, 0, 1, 1.0F}};
    return def;
}

TEST(Sugeno, InterpolatesBetweenConstants) {
    for (float x = 0.0F; x <= 1.0F; x += 0.0625F) {
        EXPECT_NEAR(evaluate(line_def(), {x}), 3.0F - 8.0F * x, 8.0F * kRounding);
    }
}

TEST(Sugeno, BlendsLinearFunctions) {
    FuzzyDef def = line_def();
    def.outputs[0].values = {{"a", 1, {2}}, {"b", 4, {-1}}};
    for (float x = 0.0F; x <= 1.0F; x += 0.0625F) {
        const float closed = (1.0F - x) * (1.0F + 2.0F * x) + x * (4.0F - x);
        EXPECT_NEAR(evaluate(def, {x}), closed, 5.0F * kRounding);
    }
}

TEST(Sugeno, WeighsNegatesAndAccumulates) {
    FuzzyDef def = line_def();
    // Not low is x; any of low and high is max(1 - x, x).
    def.rules[0].when[0].negated = true;
    def.rules[0].weight = 0.5F;
    def.rules[1].when = {{0, 0, false}, {0, 1, false}};
    def.rules[1].any = true;
    for (const float x : {0.1F, 0.4F, 0.5F, 0.9F}) {
        const float first = 0.5F * x;
        const float second = std::max(1.0F - x, x);
        EXPECT_NEAR(evaluate(def, {x}),
                    (3.0F * first - 5.0F * second) / (first + second),
                    8.0F * kRounding);
    }
    def.rules[1].any = false;
    for (const float x : {0.1F, 0.4F, 0.5F, 0.9F}) {
        const float first = 0.5F * x;
        const float second = std::min(1.0F - x, x);
        EXPECT_NEAR(evaluate(def, {x}),
                    (3.0F * first - 5.0F * second) / (first + second),
                    8.0F * kRounding);
    }
}

TEST(Sugeno, SaysOtherwiseWhereNoRuleFires) {
    FuzzyDef def = line_def();
    def.inputs[0].terms[0].d = 0.4F;
    def.inputs[0].terms[1].a = 0.6F;
    def.outputs[0].otherwise = 7.5F;
    EXPECT_EQ(evaluate(def, {0.5F}), 7.5F);
    EXPECT_NE(evaluate(def, {0.3F}), 7.5F);
}

/// The union of terms, each cut off, in double precision. Its area and first moment are exact where
/// no line bends within a piece. (The pieces are so small that bends do not count.)
double exact_centroid(const std::vector<Term>& terms, const std::vector<double>& cuts) {
    constexpr int kPieces = 200000;
    double area = 0.0;
    double moment = 0.0;
    for (int p = 0; p < kPieces; ++p) {
        const double x = (p + 0.5) / kPieces;
        double height = 0.0;
        for (std::size_t t = 0; t < terms.size(); ++t) {
            height = std::max(height, std::min(cuts[t], trapezoid(terms[t], x)));
        }
        area += height;
        moment += height * x;
    }
    return moment / area;
}

/// A triangle on [0, 1] that is cut off at `cut`, by the sums of its two triangles and its box.
double closed_centroid(double a, double b, double d, double cut) {
    const double p = a + cut * (b - a);
    const double q = d - cut * (d - b);
    const double left = 0.5 * cut * (p - a);
    const double box = cut * (q - p);
    const double right = 0.5 * cut * (d - q);
    return (left * (a + 2.0 * p) / 3.0 + box * 0.5 * (p + q) + right * (2.0 * q + d) / 3.0) /
           (left + box + right);
}

/// One input x in [0, 1] whose only term has the degree x; the output is `terms[0]` cut off there.
FuzzyDef cut_def(std::vector<Term> terms, std::uint16_t samples) {
    FuzzyDef def;
    def.inputs = {{"x", 0, 1, {{"is", 0, 1, 1, kInfinity}}}};
    FuzzyOutput out;
    out.inference = Inference::kMamdani;
    out.terms = std::move(terms);
    out.samples = samples;
    def.outputs = {out};
    def.rules = {{{{0, 0, false}}, false, 0, 0, 1.0F}};
    return def;
}

TEST(Mamdani, FindsTheCentroidOfATriangleThatIsCutOff) {
    for (const std::uint16_t samples : {50, 100, 400}) {
        const double h = 1.0 / samples;
        for (const double apex : {0.3, 0.5, 0.7}) {
            const Term term{"t", 0.1F, static_cast<float>(apex), static_cast<float>(apex), 0.9F};
            for (const double cut : {0.1, 0.35, 0.5, 0.8, 1.0}) {
                const double closed = closed_centroid(0.1, apex, 0.9, cut);
                // The midpoint rule is exact on straight lines; within a piece where the slope
                // jumps by J it is off by at most J h^2 / 8, likewise in the moment with |x| <= 1.
                // Where x f(x) is curved, f' h^2 / 12 is added, on pieces that together are 1 long.
                const double rise = 1.0 / (apex - 0.1);
                const double fall = 1.0 / (0.9 - apex);
                const double sum = (2.0 * (rise + fall) / 8.0 + (rise + fall) / 12.0) * h * h;
                const double area = 0.5 * cut * (0.8 + 0.8 * (1.0 - cut));
                const double bound = 2.0 * sum / area + static_cast<double>(kRounding);
                EXPECT_NEAR(static_cast<double>(
                                evaluate(cut_def({term}, samples), {static_cast<float>(cut)})),
                            closed,
                            bound)
                    << samples << " " << apex << " " << cut;
            }
        }
    }
}

TEST(Mamdani, TakesTheLargestOfWhatRulesSay) {
    FuzzyDef def = brave_def(Inference::kMamdani);
    // Distance 10: near 0.5, middle 0.5. Health 0.3: low 2/3, fair 1/3. So timid min(0.5, 2/3) =
    // 0.5 twice, wary 1/3 twice.
    const double closed = exact_centroid(def.outputs[0].terms, {0.5, 1.0 / 3.0, 0.0});
    // Slopes of 4 and less, at most 8 bends; see above. The area is above 0.25.
    const double h = 0.01;
    EXPECT_NEAR(static_cast<double>(evaluate(def, {10.0F, 0.3F})),
                closed,
                2.0 * (8 * 4.0 / 8.0 + 4.0 / 12.0) * h * h / 0.25);
}

/// The rules as they are written, in double precision.
double naive(const FuzzyDef& def, double distance, double health) {
    double weights = 0.0;
    double sum = 0.0;
    std::vector<double> cuts(def.outputs[0].terms.size(), 0.0);
    for (const Rule& rule : def.rules) {
        const double degree = std::min(trapezoid(def.inputs[0].terms[rule.when[0].term], distance),
                                       trapezoid(def.inputs[1].terms[rule.when[1].term], health));
        weights += degree;
        if (def.outputs[0].inference == Inference::kSugeno) {
            sum += degree * static_cast<double>(def.outputs[0].values[rule.then].constant);
        } else {
            cuts[rule.then] = std::max(cuts[rule.then], degree);
        }
    }
    return def.outputs[0].inference == Inference::kSugeno
               ? sum / weights
               : exact_centroid(def.outputs[0].terms, cuts);
}

TEST(FuzzySystem, DoesWhatItsRulesSay) {
    core::Rng rng(41);
    for (const Inference inference : {Inference::kSugeno, Inference::kMamdani}) {
        const FuzzyDef def = brave_def(inference);
        const double bound = inference == Inference::kSugeno
                                 ? static_cast<double>(kRounding)
                                 : 2.0 * (8 * 4.0 / 8.0 + 4.0 / 12.0) * 1e-4 / 0.2;
        for (int trial = 0; trial < 100; ++trial) {
            const float distance = rng.range(0.0F, 40.0F);
            const float health = rng.range(0.0F, 1.0F);
            EXPECT_NEAR(static_cast<double>(evaluate(def, {distance, health})),
                        naive(def, static_cast<double>(distance), static_cast<double>(health)),
                        bound);
        }
    }
}

TEST(FuzzySystem, NeverLeavesItsRangeWhateverItSenses) {
    core::Rng rng(43);
    const float odd[] = {
        kNan, kInfinity, -kInfinity, 3e38F, -3e38F, 1e-40F, 0.0F, -0.0F, 15.0F, 0.5F};
    for (const Inference inference : {Inference::kSugeno, Inference::kMamdani}) {
        FuzzyDef def = brave_def(inference);
        if (inference == Inference::kSugeno) {
            def.outputs[0].values[1] = {"wild", 100.0F, {-1e30F, 3e38F}};
        }
        for (const float a : odd) {
            for (const float b : odd) {
                const float out = evaluate(def, {a, b});
                EXPECT_TRUE(out >= 0.0F && out <= 1.0F) << a << " " << b << " gives " << out;
            }
        }
    }
}

TEST(FuzzySystem, AllocatesNothing) {
    for (const Inference inference : {Inference::kSugeno, Inference::kMamdani}) {
        const FuzzySystem system(brave_def(inference));
        const float in[] = {12.0F, 0.4F};
        float out = 0.0F;
        const std::uint64_t before = allocation_count();
        system.evaluate(in, {&out, 1});
        EXPECT_EQ(allocation_count(), before);
    }
}

TEST(FuzzySystem, ExplainsWhichRulesFire) {
    const FuzzySystem system(brave_def(Inference::kSugeno));
    std::vector<float> degrees;
    const float in[] = {10.0F, 0.3F};
    system.explain(in, degrees);
    ASSERT_EQ(degrees.size(), 9U);
    EXPECT_NEAR(degrees[0], 0.5F, kRounding);         // near and low
    EXPECT_NEAR(degrees[1], 1.0F / 3.0F, kRounding);  // near and fair
    EXPECT_EQ(degrees[2], 0.0F);                      // near and good
}

// ---------------------------------------------------------------- state machines

/// Two states; x in [0, 1] calls for the second to the degree x and for the first to 1 - x.
FuzzyStateMachineDef swing_def(float response_s) {
    FuzzyStateMachineDef def;
    def.inputs = line_def().inputs;
    def.states = {"calm", "angry"};
    def.transitions = {{0, 1, {{0, 1, false}}, false}, {1, 0, {{0, 0, false}}, false}};
    def.response_s = response_s;
    return def;
}

class Swing {
  public:
    explicit Swing(const FuzzyStateMachineDef& def, float dt = 0.1F)
        : machine(def, dt),
          degrees(machine.states()) {
        degrees[0] = 1.0F;
    }

    const std::vector<float>& step(float x) {
        machine.step({&x, 1}, degrees);
        return degrees;
    }

    FuzzyStateMachine machine;
    std::vector<float> degrees;
};

TEST(FuzzyStateMachine, FollowsATraceComputedByHand) {
    Swing swing(swing_def(0.0F));
    EXPECT_THAT(swing.step(0.0F), ElementsAre(1.0F, 0.0F));
    // Calm keeps 1 - 0.25, angry gets 0.25: scaled by 1 / 0.75.
    EXPECT_THAT(swing.step(0.25F), ElementsAre(1.0F, testing::FloatNear(1.0F / 3.0F, kRounding)));
    // Calm keeps min(1, 1 - 0.75) = 0.25 and gets min(1/3, 0.25); angry keeps min(1/3, 0.75) and
    // gets min(1, 0.75) = 0.75: scaled by 1 / 0.75.
    EXPECT_THAT(swing.step(0.75F), ElementsAre(testing::FloatNear(1.0F / 3.0F, kRounding), 1.0F));
    EXPECT_THAT(swing.step(1.0F), ElementsAre(0.0F, 1.0F));
}

TEST(FuzzyStateMachine, MovesNoFasterThanItsResponse) {
    Swing swing(swing_def(1.0F));  // 0.1 s steps: 0.1 a step
    EXPECT_THAT(
        swing.step(1.0F),
        ElementsAre(testing::FloatNear(0.9F, kRounding), testing::FloatNear(0.1F, kRounding)));
    EXPECT_THAT(
        swing.step(1.0F),
        ElementsAre(testing::FloatNear(0.8F, kRounding), testing::FloatNear(0.2F, kRounding)));
    for (int k = 0; k < 20; ++k) {
        swing.step(1.0F);
    }
    EXPECT_THAT(swing.step(1.0F), ElementsAre(0.0F, 1.0F));
}

TEST(FuzzyStateMachine, AlwaysHasAState) {
    core::Rng rng(53);
    for (const float response : {0.0F, 0.35F, 1.0F}) {
        FuzzyStateMachineDef def = swing_def(response);
        def.states.push_back("odd");
        def.transitions.push_back({1, 2, {{0, 0, true}, {0, 1, false}}, true});
        def.transitions.push_back({2, 0, {{0, 1, true}}, false});
        Swing swing(def);
        for (int k = 0; k < 20000; ++k) {
            const float x = rng.below(50) == 0 ? kNan : rng.range(-0.5F, 1.5F);
            float sum = 0.0F;
            for (const float degree : swing.step(x)) {
                ASSERT_TRUE(degree >= 0.0F && degree <= 1.0F);
                sum += degree;
            }
            ASSERT_GT(sum, 0.0F);
        }
    }
}

// ---------------------------------------------------------------- definitions

TEST(FuzzyDefects, AreNoneInASystemThatRuns) {
    EXPECT_TRUE(defects_of(brave_def(Inference::kSugeno)).empty());
    EXPECT_TRUE(defects_of(brave_def(Inference::kMamdani)).empty());
}

TEST(FuzzyDefects, NameTheGap) {
    FuzzyDef def = brave_def(Inference::kSugeno);
    def.inputs[0].terms[0].d = 12.0F;
    def.inputs[0].terms[1] = {"middle", 14.0F, 20.0F, 20.0F, 30.0F};
    const auto defects = defects_of(def);
    ASSERT_EQ(defects.size(), 1U);
    EXPECT_EQ(defects[0].kind, FuzzyDefectKind::kGap);
    EXPECT_EQ(defects[0].from, 12.0F);
    EXPECT_EQ(defects[0].to, 14.0F);
    EXPECT_EQ(text_of(defects[0]), "values between 12 and 14 belong to no term");
}

TEST(FuzzyDefects, NameASingleValueBetweenTwoTerms) {
    FuzzyDef def = brave_def(Inference::kSugeno);
    def.inputs[0].terms = {{"near", -kInfinity, 5, 5, 15}, {"far", 15, 30, 30, kInfinity}};
    def.rules.erase(def.rules.begin() + 6, def.rules.end());
    const auto defects = defects_of(def);
    ASSERT_EQ(defects.size(), 1U);
    EXPECT_EQ(text_of(defects[0]), "the value 15 belongs to no term");
    // An upright edge belongs to its term.
    def.inputs[0].terms[0].c = 15;
    EXPECT_TRUE(defects_of(def).empty());
}

TEST(FuzzyDefects, SeeGapsAtBothEnds) {
    FuzzyDef def = brave_def(Inference::kSugeno);
    def.inputs[1].terms[0] = {"low", 0.1F, 0.2F, 0.2F, 0.5F};
    def.inputs[1].terms[2] = {"good", 0.5F, 0.8F, 0.8F, 0.9F};
    const auto defects = defects_of(def);
    ASSERT_EQ(defects.size(), 2U);
    EXPECT_EQ(defects[0].from, 0.0F);
    EXPECT_EQ(defects[0].to, 0.1F);
    EXPECT_EQ(defects[1].from, 0.9F);
    EXPECT_EQ(defects[1].to, 1.0F);
}

std::vector<FuzzyDefectKind> kinds(const FuzzyDef& def) {
    std::vector<FuzzyDefectKind> kinds;
    for (const FuzzyDefect& defect : defects_of(def)) {
        kinds.push_back(defect.kind);
    }
    return kinds;
}

TEST(FuzzyDefects, AreEachFound) {
    const FuzzyDef good = brave_def(Inference::kSugeno);
    FuzzyDef def = good;
    def.inputs[0].high = 0.0F;
    EXPECT_THAT(kinds(def), testing::Contains(FuzzyDefectKind::kBadRange));
    def = good;
    def.inputs[0].terms[1].b = 100.0F;
    EXPECT_THAT(kinds(def), ElementsAre(FuzzyDefectKind::kBadTerm));
    def = good;
    def.inputs[0].terms.push_back({"beyond", 50, 60, 60, 70});
    EXPECT_THAT(kinds(def), ElementsAre(FuzzyDefectKind::kOutside));
    def = good;
    def.rules[4].when.clear();
    EXPECT_THAT(kinds(def), ElementsAre(FuzzyDefectKind::kNoProposition));
    def = good;
    def.rules[4].when[1].term = 3;
    EXPECT_THAT(kinds(def), ElementsAre(FuzzyDefectKind::kUnknownName));
    def = good;
    def.rules[4].then = 3;
    EXPECT_THAT(kinds(def), ElementsAre(FuzzyDefectKind::kUnknownName));
    def = good;
    def.rules[4].weight = 0.0F;
    EXPECT_THAT(kinds(def), ElementsAre(FuzzyDefectKind::kBadWeight));
    def = good;
    def.outputs[0].values.push_back({"unsaid", 0.3F, {}});
    EXPECT_THAT(kinds(def), ElementsAre(FuzzyDefectKind::kNeverSaid));
    def = good;
    def.outputs[0].otherwise = 2.0F;
    EXPECT_THAT(kinds(def), ElementsAre(FuzzyDefectKind::kBadOtherwise));
    def = brave_def(Inference::kMamdani);
    def.outputs[0].samples = 3;
    EXPECT_THAT(kinds(def), ElementsAre(FuzzyDefectKind::kBadSamples));
}

}  // namespace
}  // namespace zoned::ai::fuzzy::test
