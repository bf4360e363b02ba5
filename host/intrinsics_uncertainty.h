// What an adjustment of intrinsics is worth: covariance, what the images leave open, and whether they agree.
#pragma once

#include <string>
#include <vector>

#include "host/intrinsics_bundle.h"

namespace adit::host {

/// The inverse of the bundle's information: the intrinsics' covariance for corners of 1 px standard deviation
/// a coordinate. Inverted in units of the image corner's movement, so that rounding is judged alike for focal
/// length and k2; what the images leave open comes out as very large, not as an error.
IntrinsicMatrix InverseInformation(const IntrinsicsBundle& bundle);

/// How much farther the intrinsics scatter from image to image than corners with independent errors of
/// `sigma0_px` make them: 1 if not at all. The images' gradients g_i at the solution against what they should
/// scatter by: mean over the 8 parameters of sum g_i^T (N - N_i)^-1 g_i / sigma0^2, which is 1 on average for
/// independent errors (N_i: an image's information; Bell & McCaffrey 2002, "CR2"). A board that flexes, glass
/// before it, or a focus that moves shows here, not in the residual. Values that chance explains (within 3
/// standard deviations for this many images) return 1.
double ImageDispersion(const IntrinsicsBundle& bundle, double sigma0_px);

/// The first group of parameters that the images leave open by this covariance, as an error's text with the
/// remedy; empty if all are determined: one standard deviation moves the image's corner by less than 1 % of
/// half the diagonal.
std::string Undetermined(const IntrinsicMatrix& covariance, const optics::CameraModel& camera);

/// A sentence for each group of parameters of which one standard deviation moves the image's corner by more
/// than 1 px.
std::vector<std::string> Uncertain(const IntrinsicMatrix& covariance, const optics::CameraModel& camera);

}  // namespace adit::host
