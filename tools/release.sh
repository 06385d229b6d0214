# `./dev release TAG`: what a release has, from a tag of git, in out/release. Twice makes the same bytes.
# shellcheck shell=bash

# pack_folder FOLDER NAME: its files as NAME.tar.gz in the release, below a folder NAME.
pack_folder() {
  tar --sort=name --owner=0 --group=0 --numeric-owner --mode=u=rwX,go=rX --mtime="@$SOURCE_DATE_EPOCH" \
    --transform="s#^\.#$2#" -C "$1" -c . | gzip -9n >"$release/$2.tar.gz"
}

do_release() {
  local tag=${1:-} sources=$PWD/build-release/source release=$PWD/out/release version
  (($# == 1)) && git rev-parse --verify --quiet "refs/tags/$tag" >/dev/null || die "release takes a tag of git"
  rm -rf "$sources" "$release"
  mkdir -p "$release"
  say "checking out $tag"
  git clone --quiet --branch "$tag" "$PWD" "$sources" 2>/dev/null
  version=$(sed -n -E 's/^project\(foldproof VERSION ([0-9.]+).*/\1/p' "$sources/CMakeLists.txt")
  [[ $tag == "v$version" ]] || die "the sources of $tag are version $version, whose tag is v$version"
  SOURCE_DATE_EPOCH=$(git log -1 --format=%ct "$tag")
  export SOURCE_DATE_EPOCH
  git archive --prefix="foldproof-$version/" "$tag" | gzip -9n >"$release/foldproof-$version.tar.gz"
  local part
  for part in package wheel web npm blender; do
    (cd "$sources" && ./dev "$part") || die "the release has no $part (see above)"
  done
  cp "$sources"/out/{package/*.deb,wheel/*.whl,foldproof_addon.zip} "$release"
  cp "$sources"/out/npm/*.tgz "$release/foldproof-npm-$version.tgz"
  pack_folder "$sources/out/web" "foldproof-web-$version"
  "$sources/tools/sbom" "$version" "$(git rev-parse "$tag^{commit}")" "$release/foldproof-$version.spdx.json"
  (cd "$release" && sha256sum -- * >SHA256SUMS)
  say "done: out/release"
  (cd "$release" && ls -l)
}
