float unrelated(float x) { return x; }
float broken(vec3 l) {
    return undeclared * unrelated(l.z);
}
