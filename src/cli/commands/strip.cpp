// zygoma strip: a strip of tissue in a tensile test, as curves against closed forms.
#include "face/strip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <ostream>

#include "face/tissue.h"
#include "src/base/names.h"
#include "src/cli/command.h"
#include "src/cli/effect_options.h"
#include "src/io/atomic_file.h"
#include "src/io/output_folder.h"
#include "src/io/svg_plot.h"
#include "src/io/text.h"

namespace zygoma {
namespace {

constexpr double kSmallStrain = 1e-3;
constexpr double kLargeStrain = 0.2;
constexpr double kHighestStrain = 0.4;
constexpr int kStretchSteps = 160;
constexpr int kCycles = 6;
constexpr int kStepsPerCycle = 60;
constexpr std::array<double, 3> kRates{0.1, 1.0, 10.0};  // w tau
constexpr std::array<const char*, 3> kRateNames{"ωτ = 0.1", "ωτ = 1", "ωτ = 10"};

// One curve of an experiment, and what the closed form says where there is one.
struct Curve {
  std::string name;
  std::vector<StripPoint> points;
  std::vector<double> closed_form;  // stress; of the creep test strain
};

std::vector<std::string> remarks(const std::string& experiment, const std::vector<Curve>& curves) {
  std::vector<std::string> lines;
  for (const Curve& curve : curves) {
    const auto failed = std::count_if(curve.points.begin(),
                                      curve.points.end(),
                                      [](const StripPoint& point) { return !point.converged; });
    if (failed == 0) continue;
    lines.push_back(experiment + ", " + curve.name + ": no equilibrium in " +
                    std::to_string(failed) + " of " + std::to_string(curve.points.size()) +
                    " points");
  }
  return lines;
}

void write_curves(const std::string& path,
                  const std::string& closed_form,
                  const std::vector<Curve>& curves) {
  std::string text = "curve,time_s,strain,stress_kpa," + closed_form + ",converged\n";
  for (const Curve& curve : curves) {
    for (std::size_t k = 0; k < curve.points.size(); ++k) {
      const StripPoint& point = curve.points[k];
      text += curve.name;
      for (const double value : {point.time_s, point.strain, point.stress_kpa}) {
        text += ',';
        append_fixed(text, value, 8);
      }
      text += ',';
      if (!curve.closed_form.empty()) append_fixed(text, curve.closed_form[k], 8);
      text += point.converged ? ",1\n" : ",0\n";
    }
  }
  AtomicFile file(path);
  file.stream() << text;
  file.commit();
}

// `x`, `y`: of a point; points that are no equilibrium are left out.
template <typename X, typename Y>
PlotSeries series_of(
    const Curve& curve, std::size_t first, const X& x, const Y& y, std::size_t every = 1) {
  PlotSeries series;
  for (std::size_t k = first; k < curve.points.size(); k += every) {
    series.x.push_back(x(curve.points[k]));
    series.y.push_back(curve.points[k].converged ? y(curve.points[k]) : NAN);
  }
  return series;
}

PlotSeries named(PlotSeries series, const std::string& label, int colour, PlotMark mark) {
  series.label = label;
  series.colour = colour;
  series.mark = mark;
  return series;
}

double percent(const StripPoint& point) { return 100.0 * point.strain; }
double stress(const StripPoint& point) { return point.stress_kpa; }
double time_s(const StripPoint& point) { return point.time_s; }

// Force over stiffness and length of one spring, against its strain.
PlotSeries spring_curve(SpringLaw law) {
  constexpr double kLengthMm = 10.0;
  constexpr double kAlpha = 1.0;
  constexpr double kStiffRatio = 4.0;
  Spring spring = make_spring(0, 1, Vec3::Zero(), Vec3(kLengthMm, 0.0, 0.0), kAlpha, kStiffRatio);
  if (law == SpringLaw::kLiteral) spring = literal_spring(spring);
  PlotSeries series;
  for (int k = -50; k <= 400; ++k) {
    const double strain = 1e-3 * k;
    series.x.push_back(100.0 * strain);
    series.y.push_back(respond(spring.law, strain * spring.rest_mm).force / spring.rest_mm);
  }
  return series;
}

class StripCommand : public Command {
 public:
  std::string name() const override { return "strip"; }
  std::string help() const override { return "test a strip of tissue by pulling at it"; }
  std::string details() const override {
    return "Writes as CSV and SVG into the folder: strip_stress_strain (slow stretch), "
           "strip_relaxation (held strain), strip_creep (held load) and strip_hysteresis (cyclic "
           "stretch at three rates), the last three with viscosity and beside the closed form of "
           "the standard linear solid. It holds for springs alone; --with volume shows how much "
           "of it is left with volume preservation.";
  }
  std::string example() const override {
    return "-o result --with viscosity:ratio=0.5,relaxation_s=0.3";
  }
  int rank() const override { return 8; }
  void declare(OptionSink& options) override {
    options.text("-o,--output", folder_, "FOLDER", "where the results go; made if missing");
    effects_.declare(options);
  }

  int run(RunContext& context) override {
    std::vector<EffectChoice> effects{{"viscosity", {}}};
    effects_.apply(effects);
    require_internal(effects);
    const double ratio = value_of(effects, "ratio", 0.0);
    relaxation_s_ = value_of(effects, "relaxation_s", 1.0);
    const OutputFolder folder(folder_);
    const auto finish = [&](const char* experiment,
                            const char* closed_form,
                            const std::vector<Curve>& curves,
                            const std::vector<PlotPanel>& panels) {
      const std::string file = folder / (std::string("strip_") + experiment);
      write_curves(file + ".csv", closed_form, curves);
      write_svg_plot(file + ".svg", panels);
      for (const std::string& line : remarks(experiment, curves)) context.progress.note(line);
    };
    const std::vector<Curve> stretched = stretch();
    finish("stress_strain", "closed_form_kpa", stretched, stretch_panels(stretched));
    if (context.stop()) return 0;

    TensileTest test(make_strip(), effects);
    const StandardLinearSolid solid{test.modulus_kpa(), ratio, relaxation_s_};
    const std::vector<Curve> relaxed = relaxation(test, solid);
    finish("relaxation", "closed_form_kpa", relaxed, relaxation_panels(relaxed, solid));
    const std::vector<Curve> crept = creeping(test, solid);
    finish("creep", "closed_form_strain", crept, creep_panels(crept, solid));
    const std::vector<Curve> cycled = cycles(test, solid);
    finish("hysteresis", "closed_form_kpa", cycled, cycle_panels(cycled));
    print_deviations(relaxed, crept, cycled, solid, context.out);
    return 0;
  }

 private:
  static void require_internal(const std::vector<EffectChoice>& effects) {
    for (const EffectChoice& choice : effects) {
      require(all_effects()[require_name("--with: effect", all_effects(), choice.name)].internal,
              "--with: " + choice.name +
                  " acts from outside of the tissue, expected an effect within it");
    }
  }

  // Of viscosity; `none` where there is none.
  static double value_of(const std::vector<EffectChoice>& effects,
                         const std::string& parameter,
                         double none) {
    if (find_name(effects, "viscosity") < 0) return none;
    return effect_values("viscosity", effects)[parameter];
  }

  static std::vector<Curve> stretch() {
    const auto stretched =
        [](const std::string& name, SpringLaw law, const std::vector<EffectChoice>& effects) {
          StripOptions options;
          options.tissue.law = law;
          TensileTest test(make_strip(options), effects);
          return Curve{name, stretch_slowly(test, kHighestStrain, kStretchSteps), {}};
        };
    return {stretched("springs", SpringLaw::kSmooth, {}),
            stretched("springs_and_volume", SpringLaw::kSmooth, {{"volume", {}}}),
            stretched("printed_law", SpringLaw::kLiteral, {})};
  }

  static std::vector<PlotPanel> stretch_panels(const std::vector<Curve>& curves) {
    PlotPanel law{"One spring", {"strain (%)"}, {"force / (α L)"}, {}};
    law.series.push_back(named(spring_curve(SpringLaw::kSmooth), "smooth", 0, PlotMark::kLine));
    law.series.push_back(
        named(spring_curve(SpringLaw::kLiteral), "as printed", 1, PlotMark::kDashes));
    PlotPanel strip{"A strip of all layers", {"strain (%)"}, {"stress (kPa)"}, {}};
    const auto add = [&](int k, const char* label, int colour, PlotMark mark) {
      strip.series.push_back(named(series_of(curves[k], 0, percent, stress), label, colour, mark));
    };
    add(0, "springs", 0, PlotMark::kLine);
    add(1, "and volume", 2, PlotMark::kLine);
    add(2, "as printed", 1, PlotMark::kPoints);
    return {law, strip};
  }

  std::vector<Curve> relaxation(TensileTest& test, const StandardLinearSolid& solid) const {
    std::vector<Curve> curves;
    for (const double strain : {kSmallStrain, kLargeStrain}) {
      Curve curve{strain == kSmallStrain ? "small" : "large",
                  relax(test, strain, 5.0 * relaxation_s_, relaxation_s_ / 20.0),
                  {}};
      for (const StripPoint& point : curve.points) {
        curve.closed_form.push_back(solid.relaxing_stress(strain, point.time_s));
      }
      curves.push_back(std::move(curve));
    }
    return curves;
  }

  static PlotSeries closed_form_of(const Curve& curve, double unit) {
    PlotSeries series;
    for (std::size_t k = 0; k < curve.points.size(); ++k) {
      series.x.push_back(curve.points[k].time_s);
      series.y.push_back(curve.closed_form[k] / unit);
    }
    return series;
  }

  static std::vector<PlotPanel> relaxation_panels(const std::vector<Curve>& curves,
                                                  const StandardLinearSolid& solid) {
    PlotPanel panel{"Stress at held strain", {"time (s)"}, {"stress / (modulus × strain)"}, {}};
    for (int k = 0; k < 2; ++k) {
      const auto relative = [&](const StripPoint& point) {
        return point.stress_kpa / (solid.modulus_kpa * point.strain);
      };
      panel.series.push_back(named(series_of(curves[k], 0, time_s, relative, k == 0 ? 5 : 1),
                                   k == 0 ? "0.1 %" : "20 %",
                                   k,
                                   k == 0 ? PlotMark::kPoints : PlotMark::kLine));
    }
    panel.series.push_back(named(closed_form_of(curves[0], solid.modulus_kpa * kSmallStrain),
                                 "closed form",
                                 4,
                                 PlotMark::kDashes));
    return {panel};
  }

  std::vector<Curve> creeping(TensileTest& test, const StandardLinearSolid& solid) const {
    std::vector<Curve> curves;
    for (const double strain : {kSmallStrain, kLargeStrain}) {
      const double stress_kpa = solid.modulus_kpa * strain;
      Curve curve{strain == kSmallStrain ? "small" : "large",
                  creep(test, stress_kpa, 5.0 * relaxation_s_, relaxation_s_ / 20.0),
                  {}};
      for (const StripPoint& point : curve.points) {
        curve.closed_form.push_back(solid.creeping_strain(stress_kpa, point.time_s));
      }
      curves.push_back(std::move(curve));
    }
    return curves;
  }

  static std::vector<PlotPanel> creep_panels(const std::vector<Curve>& curves,
                                             const StandardLinearSolid& solid) {
    PlotPanel panel{"Strain under held load", {"time (s)"}, {"strain × modulus / stress"}, {}};
    for (int k = 0; k < 2; ++k) {
      const auto relative = [&](const StripPoint& point) {
        return point.strain * solid.modulus_kpa / point.stress_kpa;
      };
      panel.series.push_back(named(series_of(curves[k], 0, time_s, relative, k == 0 ? 5 : 1),
                                   k == 0 ? "light load" : "200 times that",
                                   k,
                                   k == 0 ? PlotMark::kPoints : PlotMark::kLine));
    }
    panel.series.push_back(
        named(closed_form_of(curves[0], kSmallStrain), "closed form", 4, PlotMark::kDashes));
    return {panel};
  }

  std::vector<Curve> cycles(TensileTest& test, const StandardLinearSolid& solid) const {
    std::vector<Curve> curves;
    for (const double highest : {kSmallStrain, kLargeStrain}) {
      for (std::size_t rate = 0; rate < kRates.size(); ++rate) {
        const double period_s = 2.0 * std::numbers::pi * relaxation_s_ / kRates[rate];
        Curve curve{(highest == kSmallStrain ? "small " : "large ") + shortest_text(kRates[rate]),
                    cycle(test, 0.5 * highest, period_s, kCycles, kStepsPerCycle),
                    {}};
        for (const StripPoint& point : curve.points) {
          curve.closed_form.push_back(solid.cycling_stress(0.5 * highest, period_s, point.time_s));
        }
        curves.push_back(std::move(curve));
      }
    }
    return curves;
  }

  // The last cycle of each.
  static std::vector<PlotPanel> cycle_panels(const std::vector<Curve>& curves) {
    constexpr int kFirst = (kCycles - 1) * kStepsPerCycle;
    PlotPanel small{"Up to 0.1 % (dashes: closed form)", {"strain (%)"}, {"stress (Pa)"}, {}};
    PlotPanel large{"Up to 20 %", {"strain (%)"}, {"stress (kPa)"}, {}};
    const auto pascal = [](const StripPoint& point) { return 1e3 * point.stress_kpa; };
    for (int k = 0; k < 3; ++k) {
      small.series.push_back(
          named(series_of(curves[k], kFirst, percent, pascal), kRateNames[k], k, PlotMark::kLine));
      large.series.push_back(named(
          series_of(curves[k + 3], kFirst, percent, stress), kRateNames[k], k, PlotMark::kLine));
      Curve exact = curves[k];
      for (std::size_t i = 0; i < exact.points.size(); ++i) {
        exact.points[i].stress_kpa = exact.closed_form[i];
      }
      small.series.push_back(
          named(series_of(exact, kFirst, percent, pascal), "", 4, PlotMark::kDashes));
    }
    return {small, large};
  }

  static double deviation(const Curve& curve, double (*value)(const StripPoint&)) {
    double off = 0.0;
    double largest = 0.0;
    for (std::size_t k = 0; k < curve.points.size(); ++k) {
      off = std::max(off, std::abs(value(curve.points[k]) - curve.closed_form[k]));
      largest = std::max(largest, std::abs(curve.closed_form[k]));
    }
    return off / largest;
  }

  static void print_deviations(const std::vector<Curve>& relaxed,
                               const std::vector<Curve>& crept,
                               const std::vector<Curve>& cycled,
                               const StandardLinearSolid& solid,
                               std::ostream& out) {
    const auto strain = [](const StripPoint& point) { return point.strain; };
    char line[120];
    const auto print = [&](const char* what, double small, double large) {
      std::snprintf(
          line, sizeof line, "%-26s %10.3f %% %10.1f %%\n", what, 100.0 * small, 100.0 * large);
      out << line;
    };
    std::snprintf(line, sizeof line, "modulus at rest %.3f kPa\n", solid.modulus_kpa);
    out << line << "largest deviation from the standard linear solid, of its largest value\n"
        << "                              0.1 %         20 %\n";
    print("relaxation", deviation(relaxed[0], stress), deviation(relaxed[1], stress));
    print("creep", deviation(crept[0], strain), deviation(crept[1], strain));
    for (int k = 0; k < 3; ++k) {
      print(("cycles, w tau = " + shortest_text(kRates[k])).c_str(),
            deviation(cycled[k], stress),
            deviation(cycled[k + 3], stress));
    }
  }

  std::string folder_ = "zygoma-out";
  EffectOptions effects_;
  double relaxation_s_ = 0.0;
};

}  // namespace

std::unique_ptr<Command> make_strip_command() { return std::make_unique<StripCommand>(); }

}  // namespace zygoma
