#include "server/config/npc/fuzzy_config.h"

#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "proto/config/config.pb.h"

#include <limits>
#include <set>

namespace zoned::config {

namespace {

using ai::fuzzy::FuzzyDefectKind;
using ai::fuzzy::FuzzyPart;
using proto::config::Config;

constexpr std::uint16_t kUnnamed = 0xFFFF;

template <class List>
std::uint16_t find_by_name(const List& list, const std::string& name) {
    for (int i = 0; i < list.size(); ++i) {
        if (list[i].name() == name) {
            return static_cast<std::uint16_t>(i);
        }
    }
    return kUnnamed;
}

ai::fuzzy::Term expand_term(const proto::config::FuzzyTerm& term) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    ai::fuzzy::Term out;
    out.name = term.name();
    out.a = term.has_a() ? narrow(term.a()) : -kInfinity;
    out.b = narrow(term.has_b() ? term.b() : term.c());
    out.c = narrow(term.has_c() ? term.c() : term.b());
    out.d = term.has_d() ? narrow(term.d()) : kInfinity;
    return out;
}

ai::fuzzy::Rule expand_rule(const proto::config::Fuzzy& fuzzy,
                            const proto::config::FuzzyRule& rule) {
    ai::fuzzy::Rule out;
    out.any = rule.any();
    out.weight = narrow(rule.weight());
    for (const auto& when : rule.when()) {
        ai::fuzzy::Proposition p;
        p.variable = find_by_name(fuzzy.input(), when.input());
        p.negated = when.has_is_not();
        p.term = p.variable == kUnnamed
                     ? kUnnamed
                     : find_by_name(fuzzy.input(p.variable).term(),
                                    when.has_is_not() ? when.is_not() : when.is());
        out.when.push_back(p);
    }
    out.output = rule.has_output() ? find_by_name(fuzzy.output(), rule.output()) : 0;
    out.then = kUnnamed;
    if (out.output < fuzzy.output_size()) {
        const auto& output = fuzzy.output(out.output);
        out.then = output.inference() == proto::config::SUGENO
                       ? find_by_name(output.value(), rule.then())
                       : find_by_name(output.term(), rule.then());
    }
    return out;
}

/// Names of one system.
class FuzzyNames {
  public:
    FuzzyNames(const proto::config::Fuzzy& fuzzy, std::string path, Diagnostics& diagnostics)
        : fuzzy_(fuzzy),
          path_(std::move(path)),
          diagnostics_(diagnostics) {}

    void run() {
        unique(fuzzy_.input(), path_, "input");
        unique(fuzzy_.output(), path_, "output");
        for (int i = 0; i < fuzzy_.input_size(); ++i) {
            const std::string here = join_path(path_, "input", i);
            unique(fuzzy_.input(i).term(), here, "term");
            corners(fuzzy_.input(i).term(), here);
            if (!fuzzy_.input(i).has_sense() &&
                fuzzy_.input(i).sensor() == proto::config::TIME_IN_STATE) {
                diagnostics_.add(here + ".sensor",
                                 "the time in a state is known to transitions alone");
            }
        }
        for (int o = 0; o < fuzzy_.output_size(); ++o) {
            output(fuzzy_.output(o), join_path(path_, "output", o));
        }
        for (int r = 0; r < fuzzy_.rule_size(); ++r) {
            rule(fuzzy_.rule(r), join_path(path_, "rule", r));
        }
    }

  private:
    template <class List>
    void unique(const List& list, const std::string& path, const std::string& what) {
        std::set<std::string> names;
        for (int i = 0; i < list.size(); ++i) {
            const std::string here = join_path(path, what, i);
            if (check_name(list[i].name(), what, here, diagnostics_) &&
                !names.insert(list[i].name()).second) {
                diagnostics_.add(here + ".name",
                                 "'" + list[i].name() + "' is the name of another " + what);
            }
        }
    }

    template <class Terms>
    void corners(const Terms& terms, const std::string& path) {
        for (int t = 0; t < terms.size(); ++t) {
            if (!terms[t].has_b() && !terms[t].has_c()) {
                diagnostics_.add(join_path(path, "term", t), "needs b or c");
            }
        }
    }

    void output(const proto::config::FuzzyOutput& output, const std::string& here) {
        const bool sugeno = output.inference() == proto::config::SUGENO;
        unique(output.value(), here, "value");
        unique(output.term(), here, "term");
        corners(output.term(), here);
        if (sugeno && output.term_size() > 0) {
            diagnostics_.add(join_path(here, "term", 0), "terms belong to inference: MAMDANI");
        }
        if (!sugeno && output.value_size() > 0) {
            diagnostics_.add(join_path(here, "value", 0), "values belong to inference: SUGENO");
        }
        for (int v = 0; v < output.value_size(); ++v) {
            for (int s = 0; s < output.value(v).slope_size(); ++s) {
                const std::string& input = output.value(v).slope(s).input();
                if (find_by_name(fuzzy_.input(), input) == kUnnamed) {
                    diagnostics_.add(join_path(join_path(here, "value", v), "slope", s) + ".input",
                                     "there is no input named '" + input + "'");
                }
            }
        }
    }

    void rule(const proto::config::FuzzyRule& rule, const std::string& here) {
        for (int w = 0; w < rule.when_size(); ++w) {
            const auto& when = rule.when(w);
            const std::string at = join_path(here, "when", w);
            if (when.has_is() == when.has_is_not()) {
                diagnostics_.add(at, "needs either `is` or `is_not`, a term of the input");
                continue;
            }
            const std::uint16_t input = find_by_name(fuzzy_.input(), when.input());
            const std::string& term = when.has_is() ? when.is() : when.is_not();
            if (input == kUnnamed) {
                diagnostics_.add(at + ".input", "there is no input named '" + when.input() + "'");
            } else if (find_by_name(fuzzy_.input(input).term(), term) == kUnnamed) {
                diagnostics_.add(at + (when.has_is() ? ".is" : ".is_not"),
                                 "input '" + when.input() + "' has no term named '" + term + "'");
            }
        }
        const ai::fuzzy::Rule expanded = expand_rule(fuzzy_, rule);
        if (expanded.output >= fuzzy_.output_size()) {
            diagnostics_.add(here + ".output", "there is no output named '" + rule.output() + "'");
        } else if (expanded.then == kUnnamed) {
            diagnostics_.add(here + ".then",
                             "output '" + fuzzy_.output(expanded.output).name() +
                                 "' has no value or term named '" + rule.then() + "'");
        }
    }

    const proto::config::Fuzzy& fuzzy_;
    std::string path_;
    Diagnostics& diagnostics_;
};

std::string path_of(const proto::config::Fuzzy& fuzzy,
                    const std::string& path,
                    const ai::fuzzy::FuzzyDefect& defect) {
    switch (defect.part) {
        case FuzzyPart::kInput: {
            const std::string here = join_path(path, "input", defect.index);
            return defect.element < 0 ? here : join_path(here, "term", defect.element);
        }
        case FuzzyPart::kOutput: {
            const std::string here = join_path(path, "output", defect.index);
            const bool sugeno = fuzzy.output(defect.index).inference() == proto::config::SUGENO;
            return defect.element < 0 ? here
                                      : join_path(here, sugeno ? "value" : "term", defect.element);
        }
        case FuzzyPart::kRule:
            break;
    }
    const std::string here = join_path(path, "rule", defect.index);
    return defect.element < 0 ? here : join_path(here, "when", defect.element);
}

}  // namespace

ai::fuzzy::FuzzyDef expand_fuzzy(const proto::config::Fuzzy& fuzzy) {
    ai::fuzzy::FuzzyDef out;
    out.name = fuzzy.name();
    for (const auto& input : fuzzy.input()) {
        ai::fuzzy::FuzzyVariable variable{
            input.name(), narrow(input.low()), narrow(input.high()), {}};
        for (const auto& term : input.term()) {
            variable.terms.push_back(expand_term(term));
        }
        out.inputs.push_back(std::move(variable));
    }
    for (const auto& from : fuzzy.output()) {
        ai::fuzzy::FuzzyOutput output;
        output.name = from.name();
        output.inference = static_cast<ai::fuzzy::Inference>(from.inference());
        output.low = narrow(from.low());
        output.high = narrow(from.high());
        output.otherwise = narrow(from.otherwise());
        output.samples = static_cast<std::uint16_t>(from.samples());
        for (const auto& value : from.value()) {
            ai::fuzzy::Linear line{value.name(), narrow(value.constant()), {}};
            line.of_input.assign(out.inputs.size(), 0.0F);
            for (const auto& slope : value.slope()) {
                const std::uint16_t input = find_by_name(fuzzy.input(), slope.input());
                if (input != kUnnamed) {
                    line.of_input[input] += narrow(slope.factor());
                }
            }
            output.values.push_back(std::move(line));
        }
        for (const auto& term : from.term()) {
            output.terms.push_back(expand_term(term));
        }
        out.outputs.push_back(std::move(output));
    }
    for (const auto& rule : fuzzy.rule()) {
        out.rules.push_back(expand_rule(fuzzy, rule));
    }
    return out;
}

void check_fuzzy_system(const proto::config::Fuzzy& fuzzy,
                        const std::string& path,
                        Diagnostics& diagnostics) {
    FuzzyNames(fuzzy, path, diagnostics).run();
    for (const auto& defect : ai::fuzzy::defects_of(expand_fuzzy(fuzzy))) {
        if (defect.kind != FuzzyDefectKind::kUnknownName) {  // said above, by name
            diagnostics.add(path_of(fuzzy, path, defect), ai::fuzzy::text_of(defect));
        }
    }
}

void check_fuzzy(const proto::config::Config& config, Diagnostics& diagnostics) {
    static_assert(static_cast<int>(ai::fuzzy::Inference::kMamdani) == proto::config::MAMDANI);
    std::set<std::string> names;
    for (int f = 0; f < config.fuzzy_size(); ++f) {
        const proto::config::Fuzzy& fuzzy = config.fuzzy(f);
        const std::string path = join_path("", "fuzzy", f);
        if (check_name(fuzzy.name(), "fuzzy system", path, diagnostics) &&
            !names.insert(fuzzy.name()).second) {
            diagnostics.add(path + ".name",
                            "'" + fuzzy.name() + "' is the name of another fuzzy system");
        }
        check_fuzzy_system(fuzzy, path, diagnostics);
    }
}

}  // namespace zoned::config
